// SPDX-License-Identifier: Apache-2.0
// How the decoder's tools fail: one exception, caught once in run_tool().
#ifndef NMC_DECODER_TOOL_TOOL_ERROR_H_
#define NMC_DECODER_TOOL_TOOL_ERROR_H_

#include <stdexcept>
#include <string>

#include "decoder/exit_codes.h"
#include "libnmc/include/nmc/nmc.h"

namespace nmc {

/// The message says what is wrong with which file, in words a user can act on, without a full stop or
/// newline.
class ToolError : public std::runtime_error {
 public:
  ToolError(ToolExit code, const std::string& message) : std::runtime_error(message), code_(code) {}
  ToolExit code() const { return code_; }

 private:
  ToolExit code_;
};

/// The exit code that a status of the library becomes.
inline ToolExit exit_code_of(nmc_status status) {
  switch (status) {
    case NMC_OK:
    case NMC_NEED_MORE_INPUT:
      return ToolExit::kOk;
    case NMC_ERR_NOT_NMC:
    case NMC_ERR_CORRUPT:
    case NMC_ERR_CHECKSUM:
      return ToolExit::kInvalidInput;
    case NMC_ERR_VERSION:
    case NMC_ERR_FEATURE:
      return ToolExit::kUnsupported;
    case NMC_ERR_TRUNCATED:
      return ToolExit::kCutOff;
    case NMC_ERR_LIMIT:
    case NMC_ERR_NO_MEMORY:
    case NMC_ERR_STOPPED:
      return ToolExit::kLimit;
    case NMC_ERR_ARGUMENT:
    case NMC_ERR_STATE:
      break;
  }
  return ToolExit::kInternal;
}

}  // namespace nmc

#endif  // NMC_DECODER_TOOL_TOOL_ERROR_H_

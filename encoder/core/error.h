// SPDX-License-Identifier: Apache-2.0
// How the tools fail: one exception type that carries the exit code and a message for a person.
#ifndef NMC_ENCODER_CORE_ERROR_H_
#define NMC_ENCODER_CORE_ERROR_H_

#include <stdexcept>
#include <string>

namespace nmc {

/// Exit codes of all nmc tools; documented in README.md, tested, never reused.
enum class ExitCode : int {
  kOk = 0,
  kUsage = 1,         // the command line is wrong
  kInputOutput = 2,   // a file cannot be opened, read or written
  kInvalidInput = 3,  // the input is not a valid mesh or stream
  kInternal = 4,      // a fault of nmc itself
  kUnsupported = 5,   // a valid input that uses something nmc cannot do
  kLimit = 6,         // a limit on memory, time or triangles was reached
  kTargetNotMet = 7,  // the asked error or size could not be reached, or --verify found a difference
  kCutOff = 8,        // decoded, but the file ends early
};

/// Thrown inside the encoder and caught once, in main(). The message says where (file; line or byte offset)
/// and why, in words a user can act on; it ends without a full stop and without a newline.
class Error : public std::runtime_error {
 public:
  Error(ExitCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  ExitCode code() const { return code_; }

 private:
  ExitCode code_;
};

}  // namespace nmc

#endif  // NMC_ENCODER_CORE_ERROR_H_

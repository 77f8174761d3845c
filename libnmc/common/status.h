// SPDX-License-Identifier: Apache-2.0
// How libnmc fails: a value that must be looked at. The numbers are those of nmc_status in nmc.h.
#ifndef NMC_COMMON_STATUS_H_
#define NMC_COMMON_STATUS_H_

#include <cstdint>

#include "libnmc/common/seldom.h"

namespace nmc {

enum class StatusCode : std::int32_t {
  kOk = 0,
  kNeedMoreInput = 1,
  kNotNmc = -10,
  kVersion = -12,
  kFeature = -14,
  kCorrupt = -20,
  kChecksum = -22,
  kTruncated = -24,
  kLimit = -30,
  kNoMemory = -32,
  kStopped = -34,
  kArgument = -40,
  kState = -42,
};

/// The outcome of an operation. `section` is the section of format-spec.md whose rule the stream breaks and
/// `message` a sentence about it; both are string literals and may be null.
struct [[nodiscard]] Status {
  StatusCode code = StatusCode::kOk;
  const char* section = nullptr;
  const char* message = nullptr;
  bool ok() const { return code == StatusCode::kOk; }
};

inline Status ok_status() { return {}; }
NMC_SELDOM inline Status corrupt(const char* section, const char* message) {
  return {StatusCode::kCorrupt, section, message};
}
NMC_SELDOM inline Status no_memory() { return {StatusCode::kNoMemory, nullptr, "memory exhausted"}; }

}  // namespace nmc

/// Returns from the calling function when `expression` is not ok.
#define NMC_TRY(expression)                                     \
  do {                                                          \
    const ::nmc::Status nmc_try_status = (expression);          \
    if (!nmc_try_status.ok()) return nmc_try_status;            \
  } while (false)

/// A rule of the stream: returns kCorrupt with the spec's section when it is broken.
#define NMC_CHECK_STREAM(condition, section, message)                   \
  do {                                                                  \
    if (!(condition)) return ::nmc::corrupt((section), (message));      \
  } while (false)

#endif  // NMC_COMMON_STATUS_H_

// SPDX-License-Identifier: Apache-2.0
// How libnmc fails: a value that must be looked at. The numbers are those of nmc_status in nmc.h.
#ifndef NMC_COMMON_STATUS_H_
#define NMC_COMMON_STATUS_H_

#include <cstdint>

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

/// What went wrong. `section` is the section of format-spec.md whose rule the stream breaks and `message` a sentence
/// about it; both are string literals and may be null.
struct StatusDetail {
  StatusCode code;
  const char* section;
  const char* message;
};

/// The outcome of an operation: one pointer, null when all is well, since nearly every function returns one.
class [[nodiscard]] Status {
 public:
  constexpr Status() = default;
  /// `detail` must outlive all copies: NMC_ERROR makes them from constants.
  constexpr explicit Status(const StatusDetail* detail) : detail_(detail) {}

  bool ok() const { return !detail_; }
  StatusCode code() const { return detail_ ? detail_->code : StatusCode::kOk; }
  const char* section() const { return detail_ ? detail_->section : nullptr; }
  const char* message() const { return detail_ ? detail_->message : nullptr; }

 private:
  const StatusDetail* detail_ = nullptr;
};

inline Status ok_status() { return Status(); }

}  // namespace nmc

// Where every byte counts the sentences are left to the caller: code and section say as much.
#ifdef NMC_WITHOUT_MESSAGES
#define NMC_MESSAGE(text) nullptr
#else
#define NMC_MESSAGE(text) (text)
#endif

/// A Status of constants: NMC_ERROR(kLimit, "8", "a chunk is too large").
#define NMC_ERROR(code, section, message)                                                                        \
  ([]() -> ::nmc::Status {                                                                                       \
    static constexpr ::nmc::StatusDetail detail = {::nmc::StatusCode::code, (section), NMC_MESSAGE(message)}; \
    return ::nmc::Status(&detail);                                                                               \
  }())

namespace nmc {

inline Status no_memory() { return NMC_ERROR(kNoMemory, nullptr, "memory exhausted"); }

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
    if (!(condition)) return NMC_ERROR(kCorrupt, section, message);     \
  } while (false)

#endif  // NMC_COMMON_STATUS_H_

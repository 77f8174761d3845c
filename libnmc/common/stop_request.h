// SPDX-License-Identifier: Apache-2.0
// A caller's wish to end long work.
#ifndef NMC_COMMON_STOP_REQUEST_H_
#define NMC_COMMON_STOP_REQUEST_H_

#include "libnmc/common/status.h"

namespace nmc {

/// Asked between pieces of work of a few milliseconds. Empty: never stops.
struct StopRequest {
  int (*should_stop)(void* user) = nullptr;
  void* user = nullptr;

  Status check() const {
    if (should_stop && should_stop(user)) return NMC_ERROR(kStopped, nullptr, "stopped by the caller");
    return ok_status();
  }
};

}  // namespace nmc

#endif  // NMC_COMMON_STOP_REQUEST_H_

// SPDX-License-Identifier: Apache-2.0
// How long-running stages tell a person where they are.
#ifndef NMC_ENCODER_CORE_PROGRESS_H_
#define NMC_ENCODER_CORE_PROGRESS_H_

#include <functional>
#include <string_view>

namespace nmc {

/// Called by a stage with the name of what it is doing and the fraction done in [0, 1]; may throw nmc::Error to
/// cancel. An empty function is legal everywhere.
using Progress = std::function<void(std::string_view phase, double fraction)>;

inline void report(const Progress& progress, std::string_view phase, double fraction) {
  if (progress) progress(phase, fraction);
}

}  // namespace nmc

#endif  // NMC_ENCODER_CORE_PROGRESS_H_

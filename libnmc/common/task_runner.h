// SPDX-License-Identifier: Apache-2.0
// A caller's threads.
#ifndef NMC_COMMON_TASK_RUNNER_H_
#define NMC_COMMON_TASK_RUNNER_H_

#include <cstdint>

namespace nmc {

/// Runs independent pieces of work. Empty: one after the other, where they are asked for.
struct TaskRunner {
  /// Calls task(context, i) once for each i below `task_count`, from any threads, and returns when all are done.
  void (*run_tasks)(void* user, void (*task)(void* context, std::uint32_t index), void* context,
                    std::uint32_t task_count) = nullptr;
  void* user = nullptr;
};

}  // namespace nmc

#endif  // NMC_COMMON_TASK_RUNNER_H_

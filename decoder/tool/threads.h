// SPDX-License-Identifier: Apache-2.0
// Threads for a decoder (nmc_decoder_set_threads).
#ifndef NMC_DECODER_TOOL_THREADS_H_
#define NMC_DECODER_TOOL_THREADS_H_

#include <atomic>
#include <cstdint>
#include <thread>
#include <vector>

namespace nmc {

/// How many threads run_on_threads() uses; 0 stands for all that the machine has.
struct ThreadCount {
  unsigned count = 1;
};

/// An nmc_run_tasks whose `user` is a ThreadCount: starts threads, of which each takes the next task until none is left.
/// Threads are started anew each time: levels of few tasks gain nothing.
inline void run_on_threads(void* user, void (*task)(void* context, std::uint32_t index), void* context,
                           std::uint32_t task_count) {
  unsigned count = static_cast<const ThreadCount*>(user)->count;
  if (count == 0) count = std::thread::hardware_concurrency();
  std::atomic<std::uint32_t> next{0};
  const auto work = [&] {
    for (std::uint32_t i; (i = next.fetch_add(1)) < task_count;) task(context, i);
  };
  std::vector<std::thread> others;
  for (unsigned i = 1; i < count && i < task_count; ++i) others.emplace_back(work);
  work();
  for (std::thread& other : others) other.join();
}

}  // namespace nmc

#endif  // NMC_DECODER_TOOL_THREADS_H_

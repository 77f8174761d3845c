// SPDX-License-Identifier: Apache-2.0
// The only way the encoder uses threads. Both functions give the same result for any number of threads:
// a body writes only to slots of its own range, and reductions add per-block sums in block order.
#ifndef NMC_ENCODER_CORE_PARALLEL_H_
#define NMC_ENCODER_CORE_PARALLEL_H_

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>
#include <vector>

namespace nmc {

/// Calls body(i) for every i in [0, count), in parallel and in any order. `body` must not write to anything
/// that another index reads or writes.
template <class Body>
void parallel_for(std::size_t count, const Body& body) {
  oneapi::tbb::parallel_for(oneapi::tbb::blocked_range<std::size_t>(0, count, 256),
                            [&](const oneapi::tbb::blocked_range<std::size_t>& range) {
                              for (std::size_t i = range.begin(); i != range.end(); ++i) body(i);
                            });
}

/// Sum of term(i) over [0, count). The blocks have a fixed size and are added in order, so the floating-point
/// result does not depend on the number of threads. Sum needs a default constructor (zero) and +=.
template <class Sum, class Term>
Sum parallel_sum(std::size_t count, const Term& term) {
  constexpr std::size_t kBlock = 4096;
  const std::size_t block_count = (count + kBlock - 1) / kBlock;
  std::vector<Sum> sums(block_count);
  oneapi::tbb::parallel_for(std::size_t{0}, block_count, [&](std::size_t block) {
    Sum sum{};
    const std::size_t end = std::min(count, (block + 1) * kBlock);
    for (std::size_t i = block * kBlock; i < end; ++i) sum += term(i);
    sums[block] = sum;
  });
  Sum total{};
  for (const Sum& sum : sums) total += sum;
  return total;
}

}  // namespace nmc

#endif  // NMC_ENCODER_CORE_PARALLEL_H_

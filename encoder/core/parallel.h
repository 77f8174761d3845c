// SPDX-License-Identifier: Apache-2.0
// The only way the encoder uses threads. All of them give the same result for any number of threads:
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

/// Sum of body(begin, end) over consecutive blocks of [0, count): for bodies that carry something from one
/// index to the next. The blocks have the given size and are added in order, whatever the number of threads.
template <class Sum, class Body>
Sum parallel_block_sum(std::size_t count, std::size_t block_size, const Body& body) {
  const std::size_t block_count = (count + block_size - 1) / block_size;
  std::vector<Sum> sums(block_count);
  oneapi::tbb::parallel_for(std::size_t{0}, block_count, [&](std::size_t block) {
    const std::size_t begin = block * block_size;
    sums[block] = body(begin, std::min(count, begin + block_size));
  });
  Sum total{};
  for (const Sum& sum : sums) total += sum;
  return total;
}

/// Sum of term(i) over [0, count). The blocks have a fixed size and are added in order, so the floating-point
/// result does not depend on the number of threads. Sum needs a default constructor (zero) and +=.
template <class Sum, class Term>
Sum parallel_sum(std::size_t count, const Term& term) {
  return parallel_block_sum<Sum>(count, 4096, [&](std::size_t begin, std::size_t end) {
    Sum sum{};
    for (std::size_t i = begin; i < end; ++i) sum += term(i);
    return sum;
  });
}

}  // namespace nmc

#endif  // NMC_ENCODER_CORE_PARALLEL_H_

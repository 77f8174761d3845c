// SPDX-License-Identifier: Apache-2.0
// Random numbers that are the same on every machine and in every standard library.
//
// Based on: G. Steele, D. Lea, C. Flood. Fast splittable pseudorandom number generators. OOPSLA 2014
// (SplitMix64).
#ifndef NMC_CORPUS_GENERATE_RANDOM_H_
#define NMC_CORPUS_GENERATE_RANDOM_H_

#include <cstdint>

#include "libnmc/common/vec3.h"

namespace nmc::corpus {

class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}

  std::uint64_t next() {
    std::uint64_t z = state_ += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return z ^ z >> 31;
  }
  /// Uniform in [0, 1).
  double uniform() { return static_cast<double>(next() >> 11) * 0x1p-53; }
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  /// Uniform in 0..count-1; count is at least 1.
  std::uint32_t below(std::size_t count) { return static_cast<std::uint32_t>(next() % count); }
  /// Close to a normal distribution with mean 0 and deviation 1 (sum of twelve uniforms), within -6..6.
  double normal() {
    double sum = -6;
    for (int i = 0; i < 12; ++i) sum += uniform();
    return sum;
  }
  Vec3 in_cube(double half_side) {
    const double x = uniform(-half_side, half_side), y = uniform(-half_side, half_side);
    return {x, y, uniform(-half_side, half_side)};
  }

 private:
  std::uint64_t state_;
};

}  // namespace nmc::corpus

#endif  // NMC_CORPUS_GENERATE_RANDOM_H_

// SPDX-License-Identifier: Apache-2.0
// What a coefficient costs: the interface between the quantizer and models of the entropy coder.
#ifndef NMC_ENCODER_FIT_RATE_MODEL_H_
#define NMC_ENCODER_FIT_RATE_MODEL_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "encoder/core/subdivision_hierarchy.h"

namespace nmc {

/// The normal coefficients of all levels, by the vertex that each of them places: edge e of level l belongs
/// to vertex V_l + e. Base vertices hold 0.
struct CoefficientField {
  explicit CoefficientField(const SubdivisionHierarchy& hierarchy_of, int coded_level_count)
      : hierarchy(hierarchy_of),
        level_count(coded_level_count),
        values(hierarchy_of.level(coded_level_count).vertex_count, 0) {}

  std::int32_t at(int level, std::size_t edge) const {
    return values[hierarchy.level(level).vertex_count + edge];
  }

  const SubdivisionHierarchy& hierarchy;
  int level_count;
  std::vector<std::int32_t> values;
};

/// Bits of a coefficient field under some coder. A model is taught with a whole field and then answers what
/// single changes to it would cost, its statistics held fixed.
class RateModel {
 public:
  virtual ~RateModel() = default;

  /// Takes the statistics of `field` and remembers it as the present state.
  virtual void learn(const CoefficientField& field) = 0;

  /// Bits of the coefficient (level, edge) and of all coefficients whose context it is part of, for each of
  /// the candidate values; only differences between candidates mean anything.
  virtual void costs(int level, std::size_t edge, const std::int32_t* candidates, int count,
                     double* bits) const = 0;

  /// The value that costs least: zero, or what the previous layer says.
  virtual std::int32_t resting_value(int level, std::size_t edge) const = 0;

  /// The present state changes: `value` replaces the coefficient.
  virtual void set(int level, std::size_t edge, std::int32_t value) = 0;

  /// Bits of the whole present state by the learnt statistics.
  virtual double total_bits() const = 0;
};

}  // namespace nmc

#endif  // NMC_ENCODER_FIT_RATE_MODEL_H_

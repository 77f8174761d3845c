// SPDX-License-Identifier: Apache-2.0
// A rate model shaped like the coefficient coder's main context: the weighted mean magnitude of the edges
// already coded around an edge, of its end points' coefficients and of the opposite vertices' (libnmc/common/
// coefficient_coder.h), one static distribution of magnitudes per class of that mean and per level.
//
// A real coder mixes several contexts and adapts; decisions need only differences of bits, for which the main
// context serves nearly as well and costs one look-up. A change of one coefficient is charged with what it
// does to the contexts of its neighbours and children.
#ifndef NMC_ENCODER_FIT_CONTEXT_RATE_MODEL_H_
#define NMC_ENCODER_FIT_CONTEXT_RATE_MODEL_H_

#include <array>
#include <cstdint>
#include <vector>

#include "encoder/fit/rate_model.h"

namespace nmc {

class ContextRateModel final : public RateModel {
 public:
  /// `hierarchy` must outlive the model. With `previous` (one value per vertex, multiplied to the present
  /// steps) the field is coded as corrections to a previous layer. With `next` (one value per vertex of the
  /// layer after this one, whose steps are `ratio` times finer) a value is also charged with the correction
  /// that it leaves to that layer.
  ContextRateModel(const SubdivisionHierarchy& hierarchy, int coded_level_count,
                   const std::vector<std::int32_t>* previous = nullptr, std::vector<std::int32_t> next = {},
                   int ratio = 1);

  void learn(const CoefficientField& field) override;
  void costs(int level, std::size_t edge, const std::int32_t* candidates, int count,
             double* bits) const override;
  std::int32_t resting_value(int level, std::size_t edge) const override;
  void set(int level, std::size_t edge, std::int32_t value) override;
  double total_bits() const override;

 private:
  static constexpr int kClasses = 11;
  static constexpr int kMagnitudes = 16;

  /// Edges whose context holds the coefficient of an edge, with the weight it has there.
  struct Dependent {
    std::uint32_t vertex;  // of the dependent coefficient
    std::int32_t weight;   // of a magnitude there: see the constants of the source file
  };
  struct Statistics {
    std::array<float, kMagnitudes> bits;  // of a magnitude, sign included
  };

  int context_of(std::size_t vertex, std::int64_t energy) const;
  float cost_in(int context, std::size_t vertex, std::int32_t value) const;
  float cost_in_next(std::size_t vertex, std::int32_t value) const;
  void learn_next();
  std::int64_t contribution(std::int32_t value, std::int32_t weight) const;
  void build_dependents();

  const SubdivisionHierarchy& hierarchy_;
  int level_count_;
  const std::vector<std::int32_t>* previous_;
  std::vector<std::int32_t> values_;  // per vertex
  std::vector<std::int64_t>
      fixed_energy_;                    // per vertex: what the previous layer tells of edges not yet coded
  std::vector<std::int64_t> energy_;    // per vertex: weighted sum of magnitudes around
  std::vector<std::uint8_t> level_of_;  // per vertex: 1 + level of its edge, 0 for base vertices
  std::vector<std::size_t> dependent_begin_;  // per vertex
  std::vector<Dependent> dependents_;
  std::vector<std::int32_t> normalization_;  // per vertex: divides energy_ to sixteenths
  std::vector<Statistics> statistics_;       // [layer state][level][class]
  const std::vector<std::int32_t> next_;     // per vertex; empty without a next layer
  const int ratio_;
  std::vector<Statistics> next_statistics_;  // [level][value is not zero], of corrections
};

}  // namespace nmc

#endif  // NMC_ENCODER_FIT_CONTEXT_RATE_MODEL_H_

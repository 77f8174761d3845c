// SPDX-License-Identifier: Apache-2.0
#include "libnmc/common/coefficient_coder.h"

namespace nmc {

void CoefficientModel::reset() {
  reset_untrained();
  visit_trained_states(TrainedStateReader(kTrainedCoefficientStates));
  visit_trained_mixers(set_trained_weights);
}

void CoefficientModel::reset_untrained() {
  forget_all_bits(*this);
  for (int layer = 0; layer < 2; ++layer) {
    for (auto& kinds : significance_[layer].mixer)
      for (MixerWeights& weights : kinds) weights.reset(7);
    for (MixerWeights& weights : half_blocks_[layer].mixer) weights.reset(4);
    for (MixerWeights& weights : inner_blocks_[layer].mixer) weights.reset(4);
    for (MixerWeights& weights : sign_[layer].mixer) weights.reset(6);
    for (MixerWeights& weights : magnitude_[layer].mixer) weights.reset(6);
  }
  last_half_blocks_ = last_inner_blocks_ = 0;
  run_ = 16;
}

namespace {

/// Walks two lists in order of edge; calls visit(edge, along and across of a, along and across of b).
template <class Visit>
bool merge(const Array<TangentialCoefficient>* a, const Array<TangentialCoefficient>* b, const Visit& visit) {
  std::size_t i = 0, j = 0;
  const std::size_t a_count = a ? a->size() : 0, b_count = b ? b->size() : 0;
  while (i < a_count || j < b_count) {
    const std::uint32_t edge_a = i < a_count ? (*a)[i].edge : kNone,
                        edge_b = j < b_count ? (*b)[j].edge : kNone;
    const std::uint32_t edge = edge_a < edge_b ? edge_a : edge_b;
    TangentialCoefficient from_a{edge, 0, 0}, from_b{edge, 0, 0};
    if (edge_a == edge) from_a = (*a)[i++];
    if (edge_b == edge) from_b = (*b)[j++];
    if (!visit(from_a, from_b)) return false;
  }
  return true;
}

}  // namespace

std::int32_t held_coefficient(std::int64_t value) {
  return static_cast<std::int32_t>(value > kMaximumMagnitude    ? kMaximumMagnitude
                                   : value < -kMaximumMagnitude ? -kMaximumMagnitude
                                                                : value);
}

Status subtract_tangential(const Array<TangentialCoefficient>& a, const Array<TangentialCoefficient>* b,
                           Array<TangentialCoefficient>& difference) {
  difference.clear();
  const bool done = merge(&a, b, [&](const TangentialCoefficient& s, const TangentialCoefficient& t) {
    const TangentialCoefficient d{s.edge, s.along - t.along, s.across - t.across};
    return (d.along == 0 && d.across == 0) || difference.push_back(d);
  });
  return done ? ok_status() : no_memory();
}

Status add_tangential(const Array<TangentialCoefficient>* previous,
                      const Array<TangentialCoefficient>& difference, Array<TangentialCoefficient>& sum) {
  sum.clear();
  const bool done =
      merge(previous, &difference, [&](const TangentialCoefficient& s, const TangentialCoefficient& t) {
        const TangentialCoefficient total{s.edge, held_coefficient(std::int64_t{s.along} + t.along),
                                          held_coefficient(std::int64_t{s.across} + t.across)};
        return (total.along == 0 && total.across == 0) || sum.push_back(total);
      });
  return done ? ok_status() : no_memory();
}

}  // namespace nmc

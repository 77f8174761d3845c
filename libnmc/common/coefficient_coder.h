// SPDX-License-Identifier: Apache-2.0
// The model of the coefficients: which decisions describe one level, and in which contexts (spec 5.3).
//
// One definition serves encoder, decoder and cost estimates: code_level() is a template over a Coder with
//     static constexpr bool kDecodes;
//     int code(int bit, std::uint32_t probability_16);
//     Status check() const;    // decoders: not ok when it is useless to go on
// An encoder writes `bit` and returns it, a decoder ignores it and returns what it reads, a counter adds up
// -log2 of the probability. Contexts look at integers only, never at positions, so a decoder whose
// floating-point unit were wrong would still stay in step.
#ifndef NMC_COMMON_COEFFICIENT_CODER_H_
#define NMC_COMMON_COEFFICIENT_CODER_H_

#include <cstdint>

#include "libnmc/common/context_mixing.h"
#include "libnmc/common/face_walk.h"
#include "libnmc/common/memory.h"
#include "libnmc/common/reconstruct.h"
#include "libnmc/common/status.h"
#include "libnmc/common/subdivision.h"
#include "libnmc/common/trained_states.h"

namespace nmc {

/// Largest magnitude of a coefficient (spec 8).
inline constexpr std::int32_t kMaximumMagnitude = (1 << 26) - 1;

/// `value`, held within the magnitudes that a coefficient may have.
std::int32_t held_coefficient(std::int64_t value);

namespace coefficient_internal {
struct Surroundings;
}

/// Limits of the adaptive states.
inline constexpr std::uint32_t kSignificanceCountLimit = 250;
inline constexpr std::uint32_t kMagnitudeCountLimit = 120;

/// An unsigned number: adaptive unary code for its bit length, then the bits below the leading one, the first
/// of them adaptive.
class NumberModel {
 public:
  template <class Coder>
  std::uint32_t code(Coder& coder, std::uint32_t value);

 private:
  AdaptiveBit length_[33];
  AdaptiveBit second_[33];
};

/// All adaptive state of the coefficients. It lives as long as the stream: chunks continue where the last one
/// ended.
class CoefficientModel {
 public:
  /// Starts trained (spec appendix D).
  NMC_SELDOM CoefficientModel() { reset(); }
  void reset();
  /// Knows nothing: where the training starts from.
  void reset_untrained();

  /// visit(first state, states per level, levels, levels told apart) for every table that starts trained, in
  /// the order of spec appendix D.
  template <class Visit>
  void visit_trained_states(Visit&& visit);
  /// visit(row, number of inputs, weights) for every mixer that starts trained.
  template <class Visit>
  void visit_trained_mixers(Visit&& visit);

  /// Codes the detail of the odd vertices of level `level` of `topology` (one per edge), in the order of the
  /// edges. `coarse` is the level below, null for level 0: it tells which edges lie together, and where all
  /// is quiet around such a block one decision says that the block is zero (spec 5.3.2). `previous`: the same
  /// coefficients after the previous layer, already multiplied by the ratio of the steps; null in the first
  /// layer. `vertex_values`: the normal coefficient with which each vertex of `topology` was inserted (zero
  /// for base vertices). Reads `coefficients` when encoding and fills it when decoding. `edge_number`, null or one
  /// per edge of `topology`: where it is kNone the edge is zero without being coded, and so is the other half (spec
  /// 5.4). Of `topology` only the counts and curve edges are looked at, but of level 0 all.
  template <class Coder>
  Status code_level(Coder& coder, Memory* memory, int level, const LevelTopology* coarse,
                    const LevelTopology& topology, const std::int32_t* vertex_values,
                    const LevelCoefficients* previous, LevelCoefficients& coefficients,
                    const std::uint32_t* edge_number = nullptr);

 private:
  static constexpr int kLevelClasses = 8;
  static constexpr int kUnary = 14;

  /// What code_normal() sees of a level.
  struct LevelView {
    int level_class;
    const LevelTopology& topology;
    const std::int32_t* vertex_values;
    const std::int32_t* previous;
  };
  /// How an edge comes to be coded: on its own, or within a block of which something is not zero.
  enum Kind : int {
    kHalfEdge = 0,
    kInnerEdge = 1,
    kHalfOfOpenBlock = 2,
    kInnerOfOpenBlock = 3,
    kKindCount = 4
  };

  template <class Coder>
  void code_half_edges(Coder& coder, const LevelView& view, const LevelTopology& coarse,
                       std::uint32_t coarse_edge, std::int32_t* values);
  template <class Coder>
  void code_inner_edges(Coder& coder, const LevelView& view, const LevelTopology& coarse,
                        std::uint32_t coarse_face, std::int32_t* values);
  static coefficient_internal::Surroundings look_around_half(const LevelView& view,
                                                             const LevelTopology& coarse,
                                                             std::uint32_t coarse_edge, std::uint32_t half,
                                                             const EdgeSide sides[2],
                                                             const std::int32_t* values);
  static void look_around_face(const LevelView& view, const LevelTopology& coarse, std::uint32_t coarse_face,
                               const std::int32_t* values, coefficient_internal::Surroundings around[3]);
  /// What an edge sees, found through the level's own connectivity: for level 0, and the definition of the
  /// other two.
  static coefficient_internal::Surroundings look_around(const LevelView& view, std::uint32_t edge,
                                                        const std::int32_t* values);
  template <class Coder>
  std::int32_t code_normal(Coder& coder, const LevelView& view,
                           const coefficient_internal::Surroundings& around, Kind kind, bool is_known_nonzero,
                           std::uint32_t edge, const std::int32_t* values);
  template <class Coder>
  std::int32_t code_signed(Coder& coder, NumberModel& magnitude, AdaptiveBit& sign, std::int32_t value);
  template <class Coder>
  NMC_SELDOM Status code_tangential(Coder& coder, Memory* memory, const LevelTopology& topology,
                                    const LevelCoefficients* previous, LevelCoefficients& coefficients,
                                    const std::uint32_t* edge_number);

  struct SignificanceStates {
    AdaptiveBit by_energy[kLevelClasses][kKindCount][11];
    AdaptiveBit by_neighbours[kLevelClasses][1296];
    AdaptiveBit by_parents[kLevelClasses][11][11];
    AdaptiveBit by_far_ring[12][11];
    AdaptiveBit by_run[kLevelClasses][11];
    AdaptiveBit by_all[11][11][12];
    AdaptiveBit by_sibling[kLevelClasses][kKindCount][5][11];
    MixerWeights mixer[kLevelClasses][kKindCount];
  };
  struct BlockStates {
    AdaptiveBit by_run[kLevelClasses][11];
    AdaptiveBit by_around[10][11];
    AdaptiveBit by_corners[kLevelClasses][11][2];
    AdaptiveBit by_last[kLevelClasses][4][10];
    MixerWeights mixer[kLevelClasses];
  };
  struct SignStates {
    AdaptiveBit by_neighbours[9];
    AdaptiveBit by_signed[25][3][2];
    AdaptiveBit by_parents[kLevelClasses][5];
    AdaptiveBit by_opposite[5][5];
    AdaptiveBit by_all[9][5][5];
    AdaptiveBit by_sibling[3][5];
    MixerWeights mixer[3];
  };
  struct MagnitudeStates {
    AdaptiveBit by_energy[11][kUnary];
    AdaptiveBit by_far_ring[12][kUnary];
    AdaptiveBit by_parents[kLevelClasses][11][kUnary];
    AdaptiveBit by_largest[7][kUnary];
    AdaptiveBit by_level_energy[kLevelClasses][11][kUnary];
    AdaptiveBit by_sib[5][2][kUnary];
    MixerWeights mixer[kUnary];
    NumberModel escape;
  };
  /// Index 0: nothing is known from a previous layer, or it is zero; 1: it is not zero and the number coded
  /// is the correction, with the sign taken relative to it.
  SignificanceStates significance_[2];
  SignStates sign_[2];
  MagnitudeStates magnitude_[2];
  BlockStates half_blocks_[2], inner_blocks_[2];        // [1]: there is a previous layer
  std::uint32_t last_half_blocks_, last_inner_blocks_;  // whether the last blocks were open, newest in bit 0
  std::int32_t run_;                                    // running mean of the magnitudes in 1/16

  // Tangential list: gaps between entries, and the two components.
  NumberModel tangential_count_[2];
  NumberModel gap_;
  NumberModel along_, across_;
  AdaptiveBit along_sign_, across_sign_;
  NumberModel curve_across_[3];
  AdaptiveBit curve_across_sign_[3];
};

template <class Visit>
void CoefficientModel::visit_trained_states(Visit&& visit) {
  SignificanceStates& zero = significance_[0];
  visit(&zero.by_energy[0][0][0], kKindCount * 11, kLevelClasses, kTrainedLevels);
  visit(&zero.by_neighbours[0][0], 1296, kLevelClasses, 1);
  visit(&zero.by_parents[0][0][0], 121, kLevelClasses, kTrainedLevels);
  visit(&zero.by_far_ring[0][0], 132, 1, 1);
  visit(&zero.by_run[0][0], 11, kLevelClasses, kTrainedLevels);
  visit(&zero.by_all[0][0][0], 1452, 1, 1);
  visit(&zero.by_sibling[0][0][0][0], kKindCount * 55, kLevelClasses, kTrainedLevels);
  SignStates& sign = sign_[0];
  visit(&sign.by_neighbours[0], 9, 1, 1);
  visit(&sign.by_parents[0][0], 5, kLevelClasses, 1);
  visit(&sign.by_opposite[0][0], 25, 1, 1);
  visit(&sign.by_signed[0][0][0], 150, 1, 1);
  visit(&sign.by_all[0][0][0], 225, 1, 1);
  visit(&sign.by_sibling[0][0], 15, 1, 1);
  MagnitudeStates& more = magnitude_[0];
  visit(&more.by_energy[0][0], 11 * kUnary, 1, 1);
  visit(&more.by_far_ring[0][0], 12 * kUnary, 1, 1);
  visit(&more.by_parents[0][0][0], 11 * kUnary, kLevelClasses, kTrainedLevels);
  visit(&more.by_largest[0][0], 7 * kUnary, 1, 1);
  visit(&more.by_level_energy[0][0][0], 11 * kUnary, kLevelClasses, kTrainedLevels);
  visit(&more.by_sib[0][0][0], 10 * kUnary, 1, 1);
  for (BlockStates* open : {&half_blocks_[0], &inner_blocks_[0]}) {
    visit(&open->by_run[0][0], 11, kLevelClasses, kTrainedLevels);
    visit(&open->by_around[0][0], 110, 1, 1);
    visit(&open->by_corners[0][0][0], 22, kLevelClasses, kTrainedLevels);
    visit(&open->by_last[0][0][0], 40, kLevelClasses, kTrainedLevels);
  }
}

template <class Visit>
void CoefficientModel::visit_trained_mixers(Visit&& visit) {
  const auto row = [](int first, int i) { return static_cast<TrainedMixer>(first + i); };
  for (auto& kinds : significance_[0].mixer)
    for (int kind = 0; kind < kKindCount; ++kind) visit(row(kMixSignificance, kind), 7, kinds[kind]);
  for (int kind = 0; kind < 2; ++kind) visit(row(kMixSign, kind), 6, sign_[0].mixer[kind]);
  for (int m = 0; m < kUnary; ++m) visit(row(kMixMagnitude, m < 2 ? m : 2), 6, magnitude_[0].mixer[m]);
  for (MixerWeights& weights : half_blocks_[0].mixer) visit(kMixHalfBlock, 4, weights);
  for (MixerWeights& weights : inner_blocks_[0].mixer) visit(kMixInnerBlock, 4, weights);
}

}  // namespace nmc

#include "libnmc/common/coefficient_coder_inl.h"

#endif  // NMC_COMMON_COEFFICIENT_CODER_H_

// SPDX-License-Identifier: Apache-2.0
// The values of one attribute at the vertices of a hierarchy, level by level (spec 10).
//
// Values are integers and follow from connectivity and integers alone, never from positions. The vertices
// that a level adds lie on the edges of the coarser one: interpolate there, add what the edges near by
// deviated from their own interpolation, and code the rest in steps. Everything is predicted from what a
// decoder holds, so errors do not add up from level to level. An interpolating wavelet transform in a closed
// loop, after D. Donoho. Interpolating wavelet transforms, 1992, and P. Schroeder, W. Sweldens. Spherical
// wavelets: efficiently representing functions on the sphere. SIGGRAPH 1995.
#ifndef NMC_COMMON_CODED_ATTRIBUTE_H_
#define NMC_COMMON_CODED_ATTRIBUTE_H_

#include <cstdint>

#include "libnmc/common/attribute.h"
#include "libnmc/common/attribute_coder.h"
#include "libnmc/common/memory.h"
#include "libnmc/common/status.h"
#include "libnmc/common/stop_request.h"
#include "libnmc/common/subdivision.h"

namespace nmc {

namespace attribute_internal {
class StepScale;
}

class CodedAttribute {
 public:
  explicit CodedAttribute(Memory* memory = nullptr) : values_(memory), deviations_(memory), model_(memory) {}

  /// Codes level 0: one value for each base vertex, in order. `choose(vertex, prediction, contexts, model,
  /// corrections)` sets the corrections of a vertex, given the predictions of its components and what the
  /// model looks at; encoders only. `memory` serves scratch arrays.
  template <class Coder, class Choose>
  Status code_base(Coder& coder, const AttributeDescriptor& descriptor, Memory* memory,
                   const LevelTopology& base, const Choose& choose);
  /// Codes the vertices that `level` >= 1 adds, one per edge of `coarse`, the topology of level - 1.
  template <class Coder, class Choose>
  Status code_level(Coder& coder, const AttributeDescriptor& descriptor, int level,
                    const LevelTopology& coarse, const Choose& choose);

  /// The next level to be coded: each comes once, in order.
  int next_level() const { return next_level_; }

  void begin_layer() { marked_level_ = next_level_; }
  /// Takes back the levels coded since begin_layer(); nothing older is touched by them.
  void roll_back_layer() { reset_to(marked_level_); }

  /// Predicts the vertices of `level`, whose coarser neighbours are up to date; `coarse` is the topology of
  /// level - 1. No effect on levels that are coded or predicted already.
  Status predict_level(const AttributeDescriptor& descriptor, int level, const LevelTopology& coarse,
                       StopRequest stop = {});
  /// Finest level whose values are up to date; -1 before level 0 is coded.
  int finest_known_level() const { return known_levels_ - 1; }

  /// As coded: component_count numbers per vertex, up to the finest level known.
  const std::int16_t* values() const { return values_.data(); }
  /// Hash of the values of the first `vertex_count` vertices (spec 9.4).
  std::uint64_t hash(const AttributeDescriptor& descriptor, std::uint32_t vertex_count) const;

 private:
  struct Neighbourhood;
  static std::int32_t clamped(const AttributeDescriptor& descriptor, int component, std::int32_t value) {
    const std::int32_t low = descriptor.coded_minimum(component), high = descriptor.largest_value();
    return value < low ? low : value > high ? high : value;
  }
  void interpolate(const AttributeDescriptor& descriptor, const AttributeLevel& parameters,
                   const LevelTopology& coarse, std::uint32_t edge, Neighbourhood& around) const;
  void look_around(const AttributeDescriptor& descriptor, const AttributeLevel& parameters,
                   const attribute_internal::StepScale& scale, const LevelTopology& coarse,
                   std::uint32_t edge, Neighbourhood& around, AttributeContexts& contexts) const;
  Status begin_level(int level, const AttributeDescriptor& descriptor, std::size_t vertex_count);
  void end_level(int level);
  void reset_to(int level) {
    next_level_ = level;
    if (known_levels_ > level) known_levels_ = level;
  }

  Array<std::int16_t> values_;
  Array<std::int16_t> deviations_;  // of the level that is being coded: value - interpolation
  Array<AttributeModel> model_;     // one, made with level 0
  int next_level_ = 0, known_levels_ = 0, marked_level_ = 0;
};

// ---- implementation ----

/// What is known of the vertex of one edge before it is coded.
struct CodedAttribute::Neighbourhood {
  std::uint32_t opposite[2] = {0, 0};
  int opposite_count = 0;
  std::int32_t interpolation[kMaximumComponentCount];
  std::int32_t prediction[kMaximumComponentCount];
};

namespace attribute_internal {

/// 64 / n, rounded down.
inline constexpr std::int32_t kInverse[5] = {0, 64, 32, 21, 16};

/// Divides by the steps of a level, up to the rounding of their reciprocals, which is part of the format
/// (spec 10.5.1).
class StepScale {
 public:
  StepScale(const AttributeLevel& level, int component_count) {
    for (int c = 0; c < component_count; ++c) reciprocal_[c] = 65536 / level.step[c];
  }
  std::int32_t in_steps(std::int32_t x, int component) const {
    return static_cast<std::int32_t>((static_cast<std::int64_t>(x) * reciprocal_[component]) >> 16);
  }

 private:
  std::int32_t reciprocal_[kMaximumComponentCount] = {};
};

}  // namespace attribute_internal

inline void CodedAttribute::interpolate(const AttributeDescriptor& descriptor,
                                        const AttributeLevel& parameters, const LevelTopology& coarse,
                                        std::uint32_t edge, Neighbourhood& around) const {
  const int count = descriptor.component_count;
  const std::int16_t* a = values_.data() + std::size_t{coarse.edge_vertices[2 * edge]} * count;
  const std::int16_t* b = values_.data() + std::size_t{coarse.edge_vertices[2 * edge + 1]} * count;
  const std::uint32_t left = coarse.edge_faces[2 * edge], right = coarse.edge_faces[2 * edge + 1];
  around.opposite_count = 0;
  if (right == kNone) {
    for (int c = 0; c < count; ++c) around.interpolation[c] = (a[c] + b[c] + 1) >> 1;
    return;
  }
  around.opposite[0] = coarse.opposite_vertex(edge, left);
  around.opposite[1] = coarse.opposite_vertex(edge, right);
  around.opposite_count = 2;
  const std::int16_t* o0 = values_.data() + std::size_t{around.opposite[0]} * count;
  const std::int16_t* o1 = values_.data() + std::size_t{around.opposite[1]} * count;
  const int share = parameters.opposite_share;
  for (int c = 0; c < count; ++c) {
    const std::int32_t sum = (8 - share) * (a[c] + b[c]) + share * (o0[c] + o1[c]);
    around.interpolation[c] = clamped(descriptor, c, (sum + 8) >> 4);
  }
}

inline void CodedAttribute::look_around(const AttributeDescriptor& descriptor,
                                        const AttributeLevel& parameters,
                                        const attribute_internal::StepScale& scale,
                                        const LevelTopology& coarse, std::uint32_t edge,
                                        Neighbourhood& around, AttributeContexts& contexts) const {
  using namespace attribute_internal;
  using coefficient_internal::energy_class;
  using coefficient_internal::magnitude_of;
  using coefficient_internal::sign_of;
  const int count = descriptor.component_count;
  std::uint32_t near[4];
  int near_count = 0;
  for (int side = 0; side < 2; ++side) {
    const std::uint32_t face = coarse.edge_faces[2 * edge + side];
    if (face == kNone) continue;
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t other = coarse.face_edges[3 * face + k];
      if (other < edge) near[near_count++] = other;
    }
  }
  contexts.near_count = near_count;
  const std::int16_t* a = values_.data() + std::size_t{coarse.edge_vertices[2 * edge]} * count;
  const std::int16_t* b = values_.data() + std::size_t{coarse.edge_vertices[2 * edge + 1]} * count;
  for (int c = 0; c < count; ++c) {
    AttributeContexts::Component& component = contexts.component[c];
    std::int32_t sum = 0, magnitudes = 0;
    for (int i = 0; i < near_count; ++i) {
      const std::int32_t deviation = deviations_[std::size_t{near[i]} * count + c];
      sum += deviation;
      magnitudes += magnitude_of(deviation);
    }
    component.near =
        near_count ? energy_class(scale.in_steps((magnitudes * kInverse[near_count]) >> 2, c)) : 11;
    component.near_sign = sign_of(sum);
    component.gradient = energy_class(scale.in_steps(4 * magnitude_of(a[c] - b[c]), c));
    if (around.opposite_count) {
      const std::int16_t* o0 = values_.data() + std::size_t{around.opposite[0]} * count;
      const std::int16_t* o1 = values_.data() + std::size_t{around.opposite[1]} * count;
      const std::int32_t bend = (o0[c] + o1[c]) - (a[c] + b[c]);
      component.curvature = energy_class(scale.in_steps(2 * magnitude_of(bend), c));
      component.curvature_sign = sign_of(bend);
    } else {
      component.curvature = 11;
      component.curvature_sign = 0;
    }
    const std::int32_t moved = (parameters.near_share * sum * kInverse[near_count] + 512) >> 10;
    around.prediction[c] = clamped(descriptor, c, around.interpolation[c] + moved);
  }
}

template <class Coder, class Choose>
Status CodedAttribute::code_base(Coder& coder, const AttributeDescriptor& descriptor, Memory* memory,
                                 const LevelTopology& base, const Choose& choose) {
  using namespace attribute_internal;
  using coefficient_internal::energy_class;
  NMC_TRY(begin_level(0, descriptor, base.vertex_count));
  // The neighbours of lower number, vertex after vertex.
  Array<std::uint32_t> first(memory), lower(memory);
  if (!first.resize(std::size_t{base.vertex_count} + 1) || !lower.resize(base.edge_count)) return no_memory();
  const auto ends = [&](std::uint32_t edge, std::uint32_t& low, std::uint32_t& high) {
    const std::uint32_t a = base.edge_vertices[2 * edge], b = base.edge_vertices[2 * edge + 1];
    low = a < b ? a : b;
    high = a < b ? b : a;
  };
  std::uint32_t low = 0, high = 0;
  for (std::uint32_t e = 0; e < base.edge_count; ++e) {
    ends(e, low, high);
    ++first[high];
  }
  std::uint32_t total = 0;
  for (std::uint32_t v = 0; v <= base.vertex_count; ++v) {
    total += first[v];
    first[v] = total;
  }
  for (std::uint32_t e = base.edge_count; e-- > 0;) {
    ends(e, low, high);
    lower[--first[high]] = low;
  }

  const AttributeLevel& parameters = descriptor.levels[0];
  const int count = descriptor.component_count;
  const StepScale scale(parameters, count);
  AttributeModel& model = model_[0];
  AttributeContexts contexts;
  std::int32_t prediction[kMaximumComponentCount], corrections[kMaximumComponentCount];
  std::int32_t running[kMaximumComponentCount] = {};  // mean magnitude of the last deviations, in 1/16
  for (std::uint32_t v = 0; v < base.vertex_count; ++v) {
    if constexpr (Coder::kDecodes) {
      if ((v & 8191u) == 0) NMC_TRY(coder.check());
    }
    const std::uint32_t neighbour_count = first[v + 1] - first[v];
    contexts.near_count = neighbour_count < 4 ? static_cast<int>(neighbour_count) : 4;
    for (int c = 0; c < count; ++c) {
      std::int32_t sum = 0, least = 1 << 15, largest = -(1 << 15);
      for (std::uint32_t i = first[v]; i < first[v + 1]; ++i) {
        const std::int32_t value = values_[std::size_t{lower[i]} * count + c];
        sum += value;
        least = value < least ? value : least;
        largest = value > largest ? value : largest;
      }
      AttributeContexts::Component& component = contexts.component[c];
      component.near = energy_class(scale.in_steps(running[c], c));
      component.gradient = neighbour_count ? energy_class(scale.in_steps(4 * (largest - least), c)) : 0;
      component.curvature = neighbour_count ? 0 : 11;
      if (neighbour_count) {
        const auto n = static_cast<std::int32_t>(neighbour_count);
        const std::int32_t twice = 2 * sum + n, divisor = 2 * n;
        prediction[c] = twice / divisor - (twice % divisor < 0 ? 1 : 0);
      } else {
        prediction[c] = v > 0 ? values_[std::size_t{v - 1} * count + c]
                              : (descriptor.largest_value() + descriptor.coded_minimum(c) + 1) >> 1;
      }
      corrections[c] = 0;
    }
    if constexpr (!Coder::kDecodes) choose(v, prediction, contexts, model, corrections);
    model.code_vertex<true>(coder, contexts, count, corrections);
    for (int c = 0; c < count; ++c) {
      const std::int32_t value = clamped(descriptor, c, prediction[c] + parameters.step[c] * corrections[c]);
      values_[std::size_t{v} * count + c] = static_cast<std::int16_t>(value);
      running[c] += 2 * coefficient_internal::magnitude_of(value - prediction[c]) - (running[c] >> 3);
    }
  }
  end_level(0);
  return ok_status();
}

template <class Coder, class Choose>
Status CodedAttribute::code_level(Coder& coder, const AttributeDescriptor& descriptor, int level,
                                  const LevelTopology& coarse, const Choose& choose) {
  const int count = descriptor.component_count;
  NMC_TRY(begin_level(level, descriptor, std::size_t{coarse.vertex_count} + coarse.edge_count));
  if (!deviations_.resize(std::size_t{coarse.edge_count} * count)) return no_memory();
  const AttributeLevel& parameters = descriptor.levels[level];
  const attribute_internal::StepScale scale(parameters, count);
  AttributeModel& model = model_[0];
  AttributeContexts contexts;
  contexts.level_class = level < 7 ? level : 7;
  Neighbourhood around;
  for (std::uint32_t edge = 0; edge < coarse.edge_count; ++edge) {
    if constexpr (Coder::kDecodes) {
      if ((edge & 8191u) == 0) NMC_TRY(coder.check());
    }
    interpolate(descriptor, parameters, coarse, edge, around);
    look_around(descriptor, parameters, scale, coarse, edge, around, contexts);
    std::int32_t corrections[kMaximumComponentCount] = {};
    const std::uint32_t vertex = coarse.vertex_count + edge;
    if constexpr (!Coder::kDecodes) choose(vertex, around.prediction, contexts, model, corrections);
    model.code_vertex<true>(coder, contexts, count, corrections);
    for (int c = 0; c < count; ++c) {
      const std::int32_t value =
          clamped(descriptor, c, around.prediction[c] + parameters.step[c] * corrections[c]);
      values_[std::size_t{vertex} * count + c] = static_cast<std::int16_t>(value);
      deviations_[std::size_t{edge} * count + c] = static_cast<std::int16_t>(value - around.interpolation[c]);
    }
  }
  end_level(level);
  return ok_status();
}

}  // namespace nmc

#endif  // NMC_COMMON_CODED_ATTRIBUTE_H_

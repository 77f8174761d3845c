// SPDX-License-Identifier: Apache-2.0
// Implementation of coefficient_coder.h: templates over the coder.
#ifndef NMC_COMMON_COEFFICIENT_CODER_INL_H_
#define NMC_COMMON_COEFFICIENT_CODER_INL_H_

#include <cstring>

namespace nmc {

namespace coefficient_internal {

inline std::int32_t magnitude_of(std::int32_t v) { return v < 0 ? -v : v; }
inline int sign_of(std::int32_t v) { return (v > 0) - (v < 0); }

/// Classes of a mean magnitude given in 1/16 (spec table B.2).
struct EnergyClasses {
  std::uint8_t of[257];
};
inline constexpr EnergyClasses kEnergyClasses = [] {
  constexpr int kBounds[10] = {1, 3, 6, 11, 18, 26, 40, 64, 128, 256};
  EnergyClasses classes{};
  for (int x = 0; x <= 256; ++x) {
    int k = 0;
    while (k < 10 && x >= kBounds[k]) ++k;
    classes.of[x] = static_cast<std::uint8_t>(k);
  }
  return classes;
}();
inline int energy_class(std::int32_t sixteenths) {
  return kEnergyClasses.of[sixteenths > 256 ? 256 : sixteenths];
}

/// x / n, rounded down, for x below 2^28 and n in 1 ... 8: x (ceil(2^32 / n) - 2^32 / n) stays below 2^32 /
/// n.
inline std::int32_t quotient(std::int32_t x, int n) {
  constexpr std::uint64_t kReciprocals[9] = {0,         4294967296, 2147483648, 1431655766, 1073741824,
                                             858993460, 715827883,  613566757,  536870912};
  return static_cast<std::int32_t>((static_cast<std::uint64_t>(x) * kReciprocals[n]) >> 32);
}

/// A magnitude as contexts see it: sums of a few of them then fit 32 bits with ease.
inline std::int32_t context_magnitude(std::int32_t v) {
  const std::int32_t m = magnitude_of(v);
  return m < 1023 ? m : 1023;
}

/// The coefficients of a level while they are coded in order: those before `next` are there, the others as
/// they were in the previous layer, if there is one. Nothing predicts which, so there are no branches.
struct KnownValues {
  const std::int32_t* values;
  const std::int32_t* ahead;  // of the previous layer; else anything that can be read
  std::uint32_t next;
  std::int32_t ahead_mask;

  KnownValues(const std::int32_t* current, const std::int32_t* previous, std::uint32_t first_unknown)
      : values(current),
        ahead(previous ? previous : current),
        next(first_unknown),
        ahead_mask(previous ? -1 : 0) {}
  /// All ones if something is known of edge `e`, else zero.
  std::int32_t mask(std::uint32_t e) const { return (e < next ? -1 : 0) | ahead_mask; }
  /// To be used under mask().
  std::int32_t value(std::uint32_t e) const { return (e < next ? values : ahead)[e]; }
  /// Not zero if one of the halves of a coarse edge is known to be so.
  std::int32_t pair_bits(std::uint32_t coarse_edge) const {
    const std::uint32_t e = 2 * coarse_edge;
    const std::int32_t* from = (e < next ? values : ahead) + e;
    return (from[0] | from[1]) & mask(e);
  }
};

/// What is known around one edge when it is coded (spec 5.3.1): the four near edges, which share a face with
/// it, the two further edges beyond each of them, the vertices at its ends and those opposite.
struct Surroundings {
  std::int32_t near_sum = 0, far_sum = 0, opposite_sum = 0, parent_sum = 0;
  int near_count = 0, far_count = 0;
  int near_classes[4] = {5, 5, 5, 5};  // 0 ... 3: magnitude, 4: not yet known, 5: beyond a boundary
  // Signs matter only where the coefficient turns out not to be zero: the values are kept until then.
  std::int32_t near[4] = {0, 0, 0, 0}, opposite[2] = {0, 0}, parent[2] = {0, 0};

  /// `known` is all ones, or zero for a value that is not there yet.
  void set_near(std::uint32_t i, std::int32_t v, std::int32_t known = -1) {
    near[i] = v & known;
    const std::int32_t m = context_magnitude(near[i]);
    near_sum += m;
    near_count -= known;
    near_classes[i] = (m > 3 ? 3 : m) | (~known & 4);
  }
  void add_far(std::int32_t v, std::int32_t known = -1) {
    far_sum += context_magnitude(v & known);
    far_count -= known;
  }
  void set_opposite(std::uint32_t i, std::int32_t v) {
    opposite[i] = v;
    opposite_sum += context_magnitude(v);
  }
  void set_parent(std::uint32_t i, std::int32_t v) {
    parent[i] = v;
    parent_sum += context_magnitude(v);
  }
  /// The classes of the near edges whatever their order: as digits of base 6 in increasing order.
  int neighbour_index() const {
    const auto low = [](int x, int y) { return x < y ? x : y; };
    const auto high = [](int x, int y) { return x < y ? y : x; };
    const int* c = near_classes;
    const int l01 = low(c[0], c[1]), h01 = high(c[0], c[1]), l23 = low(c[2], c[3]), h23 = high(c[2], c[3]);
    const int middle_a = high(l01, l23), middle_b = low(h01, h23);
    return low(l01, l23) +
           6 * (low(middle_a, middle_b) + 6 * (high(middle_a, middle_b) + 6 * high(h01, h23)));
  }
};

/// What the sign and the magnitude of a coefficient see besides.
struct SignsAround {
  int near_signs = 0, near_signed = 0, opposite_signs = 0, parent_signs = 0, largest = 0;

  explicit SignsAround(const Surroundings& around) {
    for (const std::int32_t v : around.near) {
      near_signs += sign_of(v);
      near_signed += v > 3 ? 3 : v < -3 ? -3 : v;
      const std::int32_t m = context_magnitude(v);
      if (m > largest) largest = m;
    }
    for (int i = 0; i < 2; ++i) {
      opposite_signs += sign_of(around.opposite[i]);
      parent_signs += sign_of(around.parent[i]);
    }
  }
};

template <class Coder>
int code_adaptive(Coder& coder, AdaptiveBit& state, int bit, std::uint32_t count_limit) {
  std::uint32_t p = state.probability_16();
  p = p < 32 ? 32 : p > 65504 ? 65504 : p;
  bit = coder.code(bit, p);
  state.update(bit, count_limit);
  return bit;
}

}  // namespace coefficient_internal

template <class Coder>
std::uint32_t NumberModel::code(Coder& coder, std::uint32_t value) {
  using namespace coefficient_internal;
  // value + 1 has `length` + 1 bits; 33 states are enough for every 32-bit value.
  const std::uint64_t number = std::uint64_t{value} + 1;
  int length = 0;
  while (length < 32) {
    const int more =
        code_adaptive(coder, length_[length], (number >> (length + 1)) != 0, kMagnitudeCountLimit);
    if (!more) break;
    ++length;
  }
  std::uint64_t result = 1;
  for (int i = length - 1; i >= 0; --i) {
    const int bit = static_cast<int>((number >> i) & 1);
    const int coded = i == length - 1 ? code_adaptive(coder, second_[length], bit, kMagnitudeCountLimit)
                                      : coder.code(bit, 32768);
    result = 2 * result + static_cast<std::uint64_t>(coded);
  }
  return static_cast<std::uint32_t>(result - 1);
}

template <class Coder>
std::int32_t CoefficientModel::code_signed(Coder& coder, NumberModel& magnitude, AdaptiveBit& sign,
                                           std::int32_t value) {
  using namespace coefficient_internal;
  std::uint32_t m = magnitude.code(coder, static_cast<std::uint32_t>(magnitude_of(value)));
  if (m == 0) return 0;
  // From one end of the range to the other it is twice the largest magnitude.
  if (m > 2 * static_cast<std::uint32_t>(kMaximumMagnitude))
    m = 2 * static_cast<std::uint32_t>(kMaximumMagnitude);
  const int negative = code_adaptive(coder, sign, value < 0, kMagnitudeCountLimit);
  return negative ? -static_cast<std::int32_t>(m) : static_cast<std::int32_t>(m);
}

NMC_SELDOM inline coefficient_internal::Surroundings CoefficientModel::look_around(
    const LevelView& view, std::uint32_t edge, const std::int32_t* values) {
  using namespace coefficient_internal;
  const LevelTopology& topology = view.topology;
  Surroundings around;
  // What is known of another edge of this level: its value if it comes earlier, else that of the previous
  // layer.
  const KnownValues known{values, view.previous, edge};
  for (std::uint32_t side = 0; side < 2; ++side) {
    const std::uint32_t face = topology.edge_faces[2 * edge + side];
    if (face == kNone) continue;
    around.set_opposite(side, view.vertex_values[topology.opposite_vertex(edge, face)]);
    std::uint32_t slot = 2 * side;
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t near = topology.face_edges[3 * face + k];
      if (near == edge) continue;
      around.set_near(slot++, known.value(near), known.mask(near));
      const std::uint32_t beyond = topology.face_across(near, face);
      if (beyond == kNone) continue;
      for (std::uint32_t j = 0; j < 3; ++j) {
        const std::uint32_t far = topology.face_edges[3 * beyond + j];
        if (far != near) around.add_far(known.value(far), known.mask(far));
      }
    }
  }
  around.set_parent(0, view.vertex_values[topology.edge_vertices[2 * edge]]);
  around.set_parent(1, view.vertex_values[topology.edge_vertices[2 * edge + 1]]);
  return around;
}

template <class Coder>
std::int32_t CoefficientModel::code_normal(Coder& coder, const LevelView& view,
                                           const coefficient_internal::Surroundings& around, Kind kind,
                                           bool is_known_nonzero, std::uint32_t edge,
                                           const std::int32_t* values) {
  using namespace coefficient_internal;
  const int level_class = view.level_class;
  const int neighbour_index = around.neighbour_index();
  const int parent_class = energy_class(8 * around.parent_sum);
  const int opposite_class = energy_class(8 * around.opposite_sum);
  const int far_class = around.far_count ? energy_class(quotient(16 * around.far_sum, around.far_count)) : 11;
  // (2 near + 0.8 parents + 0.3 opposite) / 3.1 as means, in 1/16
  const std::int32_t inherited = 64 * around.parent_sum + 24 * around.opposite_sum;
  std::int32_t energy;
  if (level_class == 0) {
    energy = around.near_count ? quotient(16 * around.near_sum, around.near_count) : 16;
  } else if (around.near_count) {
    energy = (quotient(320 * around.near_sum, around.near_count) + inherited) / 31;
  } else {
    energy = inherited / 11;
  }
  const int energy_index = energy_class(energy);
  const int run_class = energy_class(run_);

  // Halves of one parent edge follow each other; inner edges of one parent face come in threes.
  std::int32_t sibling = 0;
  int sibling_class = 4;
  if (edge > 0) {
    sibling = values[edge - 1];
    const std::int32_t m = magnitude_of(sibling);
    sibling_class = m > 3 ? 3 : m;
  }

  const std::int32_t before = view.previous ? view.previous[edge] : 0;
  const int layer = before != 0 ? 1 : 0;
  const int orientation = before < 0 ? -1 : 1;
  const std::int32_t target = (values[edge] - before) * orientation;

  if (!is_known_nonzero) {
    SignificanceStates& significance = significance_[layer];
    MixedBit<7> zero(significance.by_energy[level_class][kind][energy_index],
                     significance.by_neighbours[level_class][neighbour_index],
                     significance.by_parents[level_class][parent_class][opposite_class],
                     significance.by_far_ring[far_class][energy_index],
                     significance.by_run[level_class][run_class],
                     significance.by_all[energy_index][parent_class][far_class],
                     significance.by_sibling[level_class][kind][sibling_class][parent_class]);
    MixerWeights& zero_mixer = significance.mixer[level_class][kind];
    const int significant = coder.code(target != 0, zero.probability(zero_mixer));
    zero.update(significant, zero_mixer, kSignificanceCountLimit);
    if (!significant) {
      run_ -= run_ >> 3;
      return before;
    }
  }

  const SignsAround signs(around);
  SignStates& sign = sign_[layer];
  MixedBit<6> negative(sign.by_neighbours[signs.near_signs + 4],
                       sign.by_parents[level_class][signs.parent_signs + 2],
                       sign.by_opposite[signs.opposite_signs + 2][signs.parent_signs + 2],
                       sign.by_signed[signs.near_signed + 12][sign_of(sibling) + 1][kind & 1],
                       sign.by_all[signs.near_signs + 4][signs.parent_signs + 2][signs.opposite_signs + 2],
                       sign.by_sibling[sign_of(sibling) + 1][signs.opposite_signs + 2]);
  const int is_negative = coder.code(target < 0, negative.probability(sign.mixer[kind & 1]));
  negative.update(is_negative, sign.mixer[kind & 1], kSignificanceCountLimit);

  MagnitudeStates& magnitude = magnitude_[layer];
  const std::uint32_t excess = static_cast<std::uint32_t>(magnitude_of(target)) - 1;
  const int largest_class = around.near_count == 0 ? 6 : signs.largest > 5 ? 5 : signs.largest;
  std::uint32_t m = 0;
  while (m < kUnary) {
    MixedBit<6> more(magnitude.by_energy[energy_index][m], magnitude.by_far_ring[far_class][m],
                     magnitude.by_parents[level_class][parent_class][m],
                     magnitude.by_largest[largest_class][m],
                     magnitude.by_level_energy[level_class][energy_index][m],
                     magnitude.by_sib[sibling_class][kind & 1][m]);
    const int bit = coder.code(excess > m, more.probability(magnitude.mixer[m]));
    more.update(bit, magnitude.mixer[m], kMagnitudeCountLimit);
    if (!bit) break;
    ++m;
  }
  // From one end of the range to the other it is twice the largest magnitude.
  constexpr std::uint32_t kLargestExcess = 2 * static_cast<std::uint32_t>(kMaximumMagnitude) - 1;
  if (m == kUnary) {
    const std::uint32_t escaped = magnitude.escape.code(coder, excess - kUnary);
    m = escaped < kLargestExcess - kUnary ? escaped + kUnary : kLargestExcess;
  }
  const std::int32_t coded = static_cast<std::int32_t>(m) + 1;
  run_ += 2 * (coded > 64 ? 64 : coded) - (run_ >> 3);
  const std::int32_t value = before + orientation * (is_negative ? -coded : coded);
  return value > kMaximumMagnitude    ? kMaximumMagnitude
         : value < -kMaximumMagnitude ? -kMaximumMagnitude
                                      : value;
}

/// a - b by edge, zero entries left out; both lists are in increasing order of edge. Encoders only.
Status subtract_tangential(const Array<TangentialCoefficient>& a, const Array<TangentialCoefficient>* b,
                           Array<TangentialCoefficient>& difference);
/// previous + difference by edge, zero entries left out.
Status add_tangential(const Array<TangentialCoefficient>* previous,
                      const Array<TangentialCoefficient>& difference, Array<TangentialCoefficient>& sum);

template <class Coder>
Status CoefficientModel::code_tangential(Coder& coder, Memory* memory, const LevelTopology& topology,
                                         const LevelCoefficients* previous, LevelCoefficients& coefficients,
                                         const std::uint32_t* edge_number) {
  using namespace coefficient_internal;
  const int layer = previous ? 1 : 0;
  const auto is_foreign = [&](std::uint32_t edge) { return edge_number && edge_number[edge] == kNone; };
  Array<TangentialCoefficient> difference(memory);
  if constexpr (!Coder::kDecodes) {
    NMC_TRY(
        subtract_tangential(coefficients.tangential, previous ? &previous->tangential : nullptr, difference));
  }

  // Curves: `across` is as free as the normal offset, so it is coded for every curve edge.
  Array<TangentialCoefficient> curves(memory);
  if (topology.has_curves()) {
    std::size_t position = 0;
    int context = 0;
    for (std::uint32_t edge = 0; edge < topology.edge_count; ++edge) {
      if (!topology.edge_is_curve[edge] || is_foreign(edge)) continue;
      std::int32_t across = 0;
      if constexpr (!Coder::kDecodes) {
        while (position < difference.size() && difference[position].edge < edge) ++position;
        if (position < difference.size() && difference[position].edge == edge)
          across = difference[position].across;
      }
      across = code_signed(coder, curve_across_[context], curve_across_sign_[context], across);
      context = across == 0 ? 0 : magnitude_of(across) < 3 ? 1 : 2;
      if (Coder::kDecodes && across != 0 && !curves.push_back({edge, 0, across})) return no_memory();
    }
  }

  // The rest is sparse: a count, then gaps.
  const auto is_listed = [&](const TangentialCoefficient& t) {
    return t.along != 0 || (t.across != 0 && !topology.is_curve(t.edge));
  };
  std::uint32_t count = 0;
  for (const TangentialCoefficient& t : difference) count += is_listed(t) ? 1 : 0;
  count = tangential_count_[layer].code(coder, count);
  NMC_CHECK_STREAM(count <= topology.edge_count, "5.3.4", "more tangential coefficients than edges");
  std::uint32_t next_edge = 0;  // the lowest edge the next entry can name
  std::size_t position = 0, curve = 0;
  Array<TangentialCoefficient> decoded(memory);
  for (std::uint32_t i = 0; i < count; ++i) {
    TangentialCoefficient t{};
    if constexpr (!Coder::kDecodes) {
      while (!is_listed(difference[position])) ++position;
      t = difference[position++];
    }
    const std::uint32_t gap = gap_.code(coder, t.edge - next_edge);
    NMC_CHECK_STREAM(gap < topology.edge_count - next_edge, "5.3.4",
                     "a tangential coefficient names no edge");
    t.edge = next_edge + gap;
    next_edge = t.edge + 1;
    NMC_CHECK_STREAM(!is_foreign(t.edge), "5.4", "a tangential coefficient lies in another region");
    t.along = code_signed(coder, along_, along_sign_, t.along);
    const bool on_curve = topology.is_curve(t.edge);
    const std::int32_t across = on_curve ? 0 : code_signed(coder, across_, across_sign_, t.across);
    if constexpr (Coder::kDecodes) {
      for (; curve < curves.size() && curves[curve].edge < t.edge; ++curve) {
        if (!decoded.push_back(curves[curve])) return no_memory();
      }
      t.across = across;
      if (on_curve && curve < curves.size() && curves[curve].edge == t.edge)
        t.across = curves[curve++].across;
      if (!decoded.push_back(t)) return no_memory();
    }
    if (i + 1 < count) {
      NMC_CHECK_STREAM(next_edge < topology.edge_count, "5.3.4", "a tangential coefficient names no edge");
    }
  }
  if constexpr (Coder::kDecodes) {
    for (; curve < curves.size(); ++curve) {
      if (!decoded.push_back(curves[curve])) return no_memory();
    }
    NMC_TRY(add_tangential(previous ? &previous->tangential : nullptr, decoded, coefficients.tangential));
  }
  return ok_status();
}

inline coefficient_internal::Surroundings CoefficientModel::look_around_half(
    const LevelView& view, const LevelTopology& coarse, std::uint32_t coarse_edge, std::uint32_t half,
    const EdgeSide sides[2], const std::int32_t* values) {
  using namespace coefficient_internal;
  const std::int32_t* const previous = view.previous;
  const std::uint32_t edge = 2 * coarse_edge + half, inner_begin = 2 * coarse.edge_count;
  const KnownValues known{values, previous, edge};
  Surroundings around;
  for (std::uint32_t i = 0; i < 2; ++i) {
    const EdgeSide& side = sides[i];
    if (side.face == kNone) continue;
    // The child of the face at this end: an inner edge, and a half of the other coarse edge there.
    const bool is_tail = i == half;
    const std::uint32_t other = side.other[half];
    around.set_opposite(i, view.vertex_values[coarse.vertex_count + other]);
    if (previous) {
      const std::uint32_t corner = side.corner[half];
      const std::int32_t* inner = previous + inner_begin + std::size_t{3} * side.face;
      around.set_near(2 * i, inner[corner]);
      around.add_far(inner[next_corner(corner)]);
      around.add_far(inner[previous_corner(corner)]);
    } else {
      around.set_near(2 * i, 0, 0);
    }
    // The face runs along its other edge towards the tail of this one, and away from its head.
    const std::uint32_t near =
        is_tail ? half_at_head(coarse, other, side.face) : half_at_tail(coarse, other, side.face);
    around.set_near(2 * i + 1, known.value(near), known.mask(near));
    const FaceBeyond beyond = face_beyond(coarse, other, side.face);
    if (beyond.face == kNone) continue;
    const std::uint32_t third = is_tail ? beyond.edge_at_head : beyond.edge_at_tail;
    const std::uint32_t far =
        is_tail ? half_at_head(coarse, third, beyond.face) : half_at_tail(coarse, third, beyond.face);
    if (previous) {
      const std::uint32_t corner = is_tail ? beyond.corner_at_head : beyond.corner_at_tail;
      around.add_far(previous[inner_begin + std::size_t{3} * beyond.face + corner]);
    }
    around.add_far(known.value(far), known.mask(far));
  }
  around.set_parent(0, view.vertex_values[coarse.edge_vertices[edge]]);
  around.set_parent(1, view.vertex_values[coarse.vertex_count + coarse_edge]);
  return around;
}

/// What the three inner edges of one coarse face see, but for each other.
inline void CoefficientModel::look_around_face(const LevelView& view, const LevelTopology& coarse,
                                               std::uint32_t coarse_face, const std::int32_t* values,
                                               coefficient_internal::Surroundings around[3]) {
  using namespace coefficient_internal;
  const std::uint32_t inner_begin = 2 * coarse.edge_count;
  const KnownValues known{values, view.previous, inner_begin + 3 * coarse_face};
  std::int32_t half_sum = 0;
  for (std::uint32_t j = 0; j < 3; ++j) {
    // Edge j comes after its tail, the next corner, and before its head. The inner edges there have its odd
    // vertex as an end, the one across lies opposite to it.
    const std::uint32_t edge = coarse.face_edges[3 * coarse_face + j];
    const std::uint32_t tail = next_corner(j), head = previous_corner(j);
    Surroundings &at_tail = around[tail], &at_head = around[head];
    const std::int32_t odd_value = view.vertex_values[coarse.vertex_count + edge];
    at_tail.set_parent(0, odd_value);
    at_head.set_parent(1, odd_value);
    around[j].set_opposite(0, odd_value);
    around[j].set_opposite(1, view.vertex_values[coarse.face_vertices[3 * coarse_face + j]]);
    const std::uint32_t half = half_at_tail(coarse, edge, coarse_face);
    at_tail.set_near(0, values[half]);
    at_head.set_near(1, values[half ^ 1u]);
    const FaceBeyond beyond = face_beyond(coarse, edge, coarse_face);
    if (beyond.face == kNone) continue;
    at_tail.add_far(values[half_at_tail(coarse, beyond.edge_at_tail, beyond.face)]);
    at_head.add_far(values[half_at_head(coarse, beyond.edge_at_head, beyond.face)]);
    const std::uint32_t inner = inner_begin + 3 * beyond.face;
    at_tail.add_far(known.value(inner + beyond.corner_at_tail), known.mask(inner));
    at_head.add_far(known.value(inner + beyond.corner_at_head), known.mask(inner));
  }
  // The halves at the other two corners are far.
  for (int k = 0; k < 3; ++k) half_sum += around[k].near_sum;
  for (int k = 0; k < 3; ++k) {
    around[k].far_sum += half_sum - around[k].near_sum;
    around[k].far_count += 4;
  }
}

template <class Coder>
void CoefficientModel::code_half_edges(Coder& coder, const LevelView& view, const LevelTopology& coarse,
                                       std::uint32_t coarse_edge, std::int32_t* values) {
  using namespace coefficient_internal;
  const std::uint32_t first = 2 * coarse_edge;
  const std::int32_t* const previous = view.previous;
  const std::int32_t* const odd_values = view.vertex_values + coarse.vertex_count;
  const KnownValues known{values, previous, first};
  // Quiet: the odd vertices of the edges around, this edge among them, and the halves near to it are all
  // zero. Where even the other halves are, which is soon known, so is the sum of those.
  std::int32_t near_bits = 0, half_bits = 0, wide = 0;
  for (std::uint32_t i = 0; i < 2; ++i) {
    const std::uint32_t face = coarse.edge_faces[first + i];
    if (face == kNone) continue;
    const std::uint32_t* const edges = coarse.face_edges.data() + std::size_t{3} * face;
    near_bits |= odd_values[edges[0]] | odd_values[edges[1]] | odd_values[edges[2]];
    half_bits |= known.pair_bits(edges[0]) | known.pair_bits(edges[1]) | known.pair_bits(edges[2]);
  }
  EdgeSide sides[2];
  const auto find_sides = [&] {
    for (std::uint32_t i = 0; i < 2; ++i) sides[i] = edge_side(coarse, coarse_edge, i);
  };
  if ((near_bits | half_bits) != 0) find_sides();
  if (near_bits == 0 && half_bits != 0) {
    if (previous) near_bits |= previous[first] | previous[first + 1];
    for (std::uint32_t i = 0; i < 2; ++i) {
      if (sides[i].face == kNone) continue;
      for (std::uint32_t end = 0; end < 2; ++end) {
        const std::uint32_t other = sides[i].other[end], face = sides[i].face;
        const std::uint32_t near =
            i == end ? half_at_head(coarse, other, face) : half_at_tail(coarse, other, face);
        near_bits |= known.value(near) & known.mask(near);
        wide += context_magnitude(known.value(near ^ 1u) & known.mask(near));
      }
    }
  }
  const auto code_both = [&](Kind kind) {
    for (std::uint32_t half = 0; half < 2; ++half) {
      const bool is_known_nonzero = kind == kHalfOfOpenBlock && half == 1 && values[first] == 0;
      values[first + half] =
          code_normal(coder, view, look_around_half(view, coarse, coarse_edge, half, sides, values), kind,
                      is_known_nonzero, first + half, values);
    }
  };
  if (near_bits != 0) return code_both(kHalfEdge);
  const std::int32_t ends = context_magnitude(view.vertex_values[coarse.edge_vertices[first]]) +
                            context_magnitude(view.vertex_values[coarse.edge_vertices[first + 1]]);
  BlockStates& states = half_blocks_[previous ? 1 : 0];
  const int run_class = energy_class(run_), ends_class = energy_class(8 * ends);
  MixedBit<4> open(states.by_run[view.level_class][run_class],
                   states.by_around[wide > 9 ? 9 : wide][ends_class],
                   states.by_corners[view.level_class][ends_class][last_half_blocks_ & 1],
                   states.by_last[view.level_class][last_half_blocks_ & 3][wide > 9 ? 9 : wide]);
  MixerWeights& mixer = states.mixer[view.level_class];
  const int is_open = coder.code(values[first] != 0 || values[first + 1] != 0, open.probability(mixer));
  open.update(is_open, mixer, kSignificanceCountLimit);
  last_half_blocks_ = 2 * last_half_blocks_ + static_cast<std::uint32_t>(is_open);
  if (is_open) {
    find_sides();
    return code_both(kHalfOfOpenBlock);
  }
  values[first] = values[first + 1] = 0;
  run_ -= run_ >> 3;
  run_ -= run_ >> 3;
}

template <class Coder>
void CoefficientModel::code_inner_edges(Coder& coder, const LevelView& view, const LevelTopology& coarse,
                                        std::uint32_t coarse_face, std::int32_t* values) {
  using namespace coefficient_internal;
  const std::uint32_t first = 2 * coarse.edge_count + 3 * coarse_face;
  const std::int32_t* const previous = view.previous;
  const KnownValues known{values, previous, first};
  std::int32_t near_bits = previous ? previous[first] | previous[first + 1] | previous[first + 2] : 0;
  for (int k = 0; k < 3; ++k) {
    const std::uint32_t e = coarse.face_edges[3 * coarse_face + k];
    near_bits |= view.vertex_values[coarse.vertex_count + e] | values[2 * e] | values[2 * e + 1];
  }
  const auto code_three = [&](Kind kind) {
    Surroundings around[3];
    look_around_face(view, coarse, coarse_face, values, around);
    for (std::uint32_t k = 0; k < 3; ++k) {
      const KnownValues seen{values, previous, first + k};
      const std::uint32_t after = first + next_corner(k), before = first + previous_corner(k);
      around[k].set_near(2, seen.value(after), seen.mask(after));
      around[k].set_near(3, seen.value(before), seen.mask(before));
      const bool is_known_nonzero =
          kind == kInnerOfOpenBlock && k == 2 && values[first] == 0 && values[first + 1] == 0;
      values[first + k] = code_normal(coder, view, around[k], kind, is_known_nonzero, first + k, values);
    }
  };
  if (near_bits != 0) return code_three(kInnerEdge);
  std::int32_t wide = 0, corners = 0;
  for (int k = 0; k < 3; ++k) {
    corners += context_magnitude(view.vertex_values[coarse.face_vertices[3 * coarse_face + k]]);
    const std::uint32_t e = coarse.face_edges[3 * coarse_face + k];
    const std::uint32_t beyond = coarse.face_across(e, coarse_face);
    if (beyond == kNone) continue;
    const std::uint32_t there = 2 * coarse.edge_count + 3 * beyond;
    const std::int32_t mask = known.mask(there);
    for (std::uint32_t i = 0; i < 3; ++i) wide += context_magnitude(known.value(there + i) & mask);
  }
  BlockStates& states = inner_blocks_[previous ? 1 : 0];
  const int run_class = energy_class(run_), corner_class = energy_class(8 * corners);
  MixedBit<4> open(states.by_run[view.level_class][run_class],
                   states.by_around[wide > 9 ? 9 : wide][corner_class],
                   states.by_corners[view.level_class][corner_class][last_inner_blocks_ & 1],
                   states.by_last[view.level_class][last_inner_blocks_ & 3][wide > 9 ? 9 : wide]);
  MixerWeights& mixer = states.mixer[view.level_class];
  const int is_open = coder.code(values[first] != 0 || values[first + 1] != 0 || values[first + 2] != 0,
                                 open.probability(mixer));
  open.update(is_open, mixer, kSignificanceCountLimit);
  last_inner_blocks_ = 2 * last_inner_blocks_ + static_cast<std::uint32_t>(is_open);
  if (is_open) return code_three(kInnerOfOpenBlock);
  values[first] = values[first + 1] = values[first + 2] = 0;
  for (int i = 0; i < 3; ++i) run_ -= run_ >> 3;
}

template <class Coder>
Status CoefficientModel::code_level(Coder& coder, Memory* memory, int level, const LevelTopology* coarse,
                                    const LevelTopology& topology, const std::int32_t* vertex_values,
                                    const LevelCoefficients* previous, LevelCoefficients& coefficients,
                                    const std::uint32_t* edge_number) {
  if (!coefficients.normal.resize(topology.edge_count)) return no_memory();
  const LevelView view = {level < kLevelClasses ? level : kLevelClasses - 1, topology, vertex_values,
                          previous ? previous->normal.data() : nullptr};
  std::int32_t* const values = coefficients.normal.data();
  const auto check_now_and_then = [&](std::uint32_t i) {
    if constexpr (Coder::kDecodes) {
      if ((i & 8191u) == 0) return coder.check();
    }
    return ok_status();
  };
  if (!coarse) {
    for (std::uint32_t edge = 0; edge < topology.edge_count; ++edge) {
      NMC_TRY(check_now_and_then(edge));
      values[edge] =
          code_normal(coder, view, look_around(view, edge, values), kHalfEdge, false, edge, values);
    }
  } else {
    for (std::uint32_t edge = 0; edge < coarse->edge_count; ++edge) {
      NMC_TRY(check_now_and_then(edge));
      if (edge_number && edge_number[2 * edge] == kNone) {
        values[2 * edge] = values[2 * edge + 1] = 0;
        continue;
      }
      code_half_edges(coder, view, *coarse, edge, values);
    }
    for (std::uint32_t face = 0; face < coarse->face_count; ++face) {
      NMC_TRY(check_now_and_then(face));
      code_inner_edges(coder, view, *coarse, face, values);
    }
  }
  return code_tangential(coder, memory, topology, previous, coefficients, edge_number);
}

}  // namespace nmc

#endif  // NMC_COMMON_COEFFICIENT_CODER_INL_H_

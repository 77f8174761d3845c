// SPDX-License-Identifier: Apache-2.0
// Implementation of base_mesh_coder.h: templates over the coder.
#ifndef NMC_COMMON_BASE_MESH_CODER_INL_H_
#define NMC_COMMON_BASE_MESH_CODER_INL_H_

namespace nmc {

namespace base_mesh_internal {

/// One edge of the border, directed as in the face still to come. Borders are closed lists.
struct BorderEdge {
  std::uint32_t start;  // its first vertex; the second is the start of `next`
  std::uint32_t previous, next;
  std::uint8_t state;
};
inline constexpr std::uint8_t kOpen = 0, kBoundary = 1, kGone = 2;

/// Number of bits of |value|.
inline int bit_length(std::uint32_t value) {
  int n = 0;
  while (value) {
    ++n;
    value >>= 1;
  }
  return n;
}

inline std::uint32_t magnitude_u32(std::int64_t v) { return static_cast<std::uint32_t>(v < 0 ? -v : v); }

/// Division by a small positive count, rounded to nearest, halves upwards: the same for all signs of the sum.
inline std::int64_t rounded_quotient(std::int64_t sum, std::int64_t count) {
  const std::int64_t shifted = 2 * sum + count;
  const std::int64_t divisor = 2 * count;
  std::int64_t q = shifted / divisor;
  if (shifted % divisor < 0) --q;
  return q;
}

/// The border edge from `start` to `end` that still waits for its face. Encoders only; linear, and rarely
/// called.
inline std::uint32_t open_edge(const Array<BorderEdge>& border, std::uint32_t start, std::uint32_t end) {
  for (std::uint32_t i = 0; i < border.size(); ++i) {
    if (border[i].state == kOpen && border[i].start == start && border[border[i].next].start == end) return i;
  }
  return kNone;
}

/// The border may pass several times through the third corner w of the face (u, v, w). The right place is the
/// gap that this face lies in: turn around w over faces still to come until the border is met, to one side
/// or, where the surface ends there, to the other. Encoders only.
inline std::uint32_t place_of_corner(const FaceLookup& lookup, const Array<BorderEdge>& border,
                                     const Array<std::uint32_t>& old_index,
                                     const Array<std::uint32_t>& new_index, std::uint32_t u, std::uint32_t v,
                                     std::uint32_t w) {
  const std::uint32_t w_old = old_index[w];
  for (std::uint32_t y = old_index[u]; y != kNone && y != old_index[v]; y = lookup.third_corner(y, w_old)) {
    if (new_index[y] == kNone) continue;
    const std::uint32_t edge = open_edge(border, w, new_index[y]);
    if (edge != kNone) return edge;
  }
  for (std::uint32_t y = old_index[v]; y != kNone && y != old_index[u]; y = lookup.third_corner(w_old, y)) {
    if (new_index[y] == kNone) continue;
    const std::uint32_t edge = open_edge(border, new_index[y], w);
    if (edge != kNone) return border[edge].next;
  }
  return kNone;
}

template <class Coder>
std::uint32_t code_uniform(Coder& coder, std::uint32_t value, std::uint32_t count) {
  std::uint32_t result = 0;
  for (int i = bit_length(count - 1) - 1; i >= 0; --i) {
    result = 2 * result + static_cast<std::uint32_t>(coder.code((value >> i) & 1, 32768));
  }
  return result;
}

}  // namespace base_mesh_internal

template <class Coder>
Status BaseMeshModel::code_connectivity(Coder& coder, Memory* memory, const FaceLookup* lookup,
                                        const std::uint32_t* component_seeds, BaseMesh& mesh,
                                        Array<std::uint32_t>& old_index) {
  using namespace base_mesh_internal;
  using coefficient_internal::code_adaptive;
  const bool encoding = lookup != nullptr;
  if (!mesh.face_vertices.resize(std::size_t{3} * mesh.face_count)) return no_memory();
  Array<BorderEdge> border(memory);
  Array<std::uint32_t> degree(memory);     // faces so far around each vertex
  Array<std::uint32_t> new_index(memory);  // encoder: its vertex -> number, kNone when not yet visited
  if (!degree.resize(mesh.vertex_count)) return no_memory();
  old_index.clear();
  if (encoding && !new_index.assign(mesh.vertex_count, kNone)) return no_memory();
  std::uint32_t vertex_count = 0, face_count = 0, gate = 0, seed_count = 0;

  const auto add_vertex = [&](std::uint32_t old) -> bool {
    if (encoding) {
      new_index[old] = vertex_count;
      if (!old_index.push_back(old)) return false;
    }
    ++vertex_count;
    return true;
  };
  const auto add_face = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    std::uint32_t* corners = mesh.face_vertices.data() + std::size_t{3} * face_count++;
    corners[0] = a;
    corners[1] = b;
    corners[2] = c;
    ++degree[a];
    ++degree[b];
    ++degree[c];
  };
  const auto degree_class = [&](std::uint32_t v) {
    return degree[v] < kDegreeClasses ? degree[v] : std::uint32_t{kDegreeClasses - 1};
  };
  // A border of two edges is two sides of one edge: it closes. With a marked boundary in it the mesh is
  // broken.
  const auto close_if_two = [&](std::uint32_t i) -> Status {
    const std::uint32_t j = border[i].next;
    if (border[j].next != i) return ok_status();
    NMC_CHECK_STREAM(border[i].state == kOpen && border[j].state == kOpen, "4.4",
                     "a border closes on a boundary");
    border[i].state = border[j].state = kGone;
    return ok_status();
  };

  while (face_count < mesh.face_count) {
    // A new component starts with a face of three new vertices.
    NMC_CHECK_STREAM(mesh.vertex_count - vertex_count >= 3, "4.4", "more faces than the vertices allow");
    std::uint32_t seed[3] = {0, 0, 0};
    if (encoding) {
      for (int k = 0; k < 3; ++k) seed[k] = component_seeds[3 * seed_count + k];
    }
    ++seed_count;
    const std::uint32_t first = vertex_count, edge0 = static_cast<std::uint32_t>(border.size());
    for (std::uint32_t k = 0; k < 3; ++k) {
      if (!add_vertex(seed[k])) return no_memory();
    }
    add_face(first, first + 1, first + 2);
    // Seen from the neighbouring faces the edges run backwards: 0 -> 2 -> 1 -> 0.
    const std::uint32_t starts[3] = {first, first + 2, first + 1};
    for (std::uint32_t k = 0; k < 3; ++k) {
      if (!border.push_back({starts[k], edge0 + (k + 2) % 3, edge0 + (k + 1) % 3, kOpen})) return no_memory();
    }

    for (; gate < border.size(); ++gate) {
      while (border[gate].state == kOpen) {
        const std::uint32_t i = gate, u = border[i].start, next = border[i].next,
                            previous = border[i].previous;
        const std::uint32_t v = border[next].start;
        const std::uint32_t left = border[previous].start, right = border[border[next].next].start;
        const bool can_left = border[previous].state == kOpen, can_right = border[next].state == kOpen;

        std::uint32_t third = kNone;  // in the new numbering; kNone for a boundary or a new vertex
        std::uint32_t third_old = kNone;
        bool is_new = false, is_boundary = false;
        if (encoding) {
          third_old = lookup->third_corner(old_index[u], old_index[v]);
          is_boundary = third_old == kNone;
          if (!is_boundary) {
            third = new_index[third_old];
            is_new = third == kNone;
          }
        }
        const std::uint32_t du = degree_class(u), dv = degree_class(v);
        {
          MixedBit<3> bit(is_new_[du][dv], is_new_by_u_[du], is_new_by_v_[dv]);
          is_new = coder.code(is_new, bit.probability(is_new_mixer_)) != 0;
          bit.update(is_new, is_new_mixer_, kMagnitudeCountLimit);
        }
        if (is_new) {
          NMC_CHECK_STREAM(vertex_count < mesh.vertex_count, "4.4", "more vertices than announced");
          NMC_CHECK_STREAM(face_count < mesh.face_count, "4.4", "more faces than announced");
          const std::uint32_t w = vertex_count;
          if (!add_vertex(third_old)) return no_memory();
          add_face(u, v, w);
          const auto k = static_cast<std::uint32_t>(border.size());
          if (!border.push_back({w, i, next, kOpen})) return no_memory();
          border[i].next = k;
          border[next].previous = k;
          continue;
        }
        if (can_left) {
          // Only the border edge itself can be meant: its start may appear elsewhere on the border too.
          const bool is_left =
              code_adaptive(coder, is_left_[du], third == left && !is_boundary, kMagnitudeCountLimit) != 0;
          if (is_left) {
            NMC_CHECK_STREAM(face_count < mesh.face_count, "4.4", "more faces than announced");
            add_face(u, v, left);
            border[i].state = kGone;
            border[previous].next = next;
            border[next].previous = previous;
            NMC_TRY(close_if_two(previous));
            continue;
          }
        }
        if (can_right) {
          const bool is_right =
              code_adaptive(coder, is_right_[dv], third == right && !is_boundary, kMagnitudeCountLimit) != 0;
          if (is_right) {
            NMC_CHECK_STREAM(face_count < mesh.face_count, "4.4", "more faces than announced");
            add_face(u, v, right);
            border[next].state = kGone;
            border[i].next = border[next].next;
            border[border[i].next].previous = i;
            NMC_TRY(close_if_two(i));
            continue;
          }
        }
        const int boundary_context = (can_left ? 0 : 1) + (can_right ? 0 : 1);
        is_boundary =
            code_adaptive(coder, is_boundary_[boundary_context], is_boundary, kMagnitudeCountLimit) != 0;
        if (is_boundary) {
          border[i].state = kBoundary;
          continue;
        }

        // Some other place of the border, which splits it or joins two of them. The place is a border edge
        // that starts at the third corner: near this one along the border, or named by its number.
        constexpr std::uint32_t kNearest = 32;
        std::uint32_t place = kNone, distance = 0;
        int side = 0, is_near = 0;
        if (encoding) {
          place = place_of_corner(*lookup, border, old_index, new_index, u, v, third);
          if (place == kNone) return NMC_ERROR(kArgument, nullptr, "the base mesh is not a manifold");
          std::uint32_t forward = border[next].next, backward = previous;
          for (std::uint32_t step = 0; step < kNearest && !is_near; ++step) {
            if (forward == place || backward == place) {
              is_near = 1;
              side = forward == place ? 0 : 1;
              distance = step;
            }
            forward = border[forward].next;
            backward = border[backward].previous;
          }
        }
        is_near = code_adaptive(coder, is_near_, is_near, kMagnitudeCountLimit);
        if (is_near) {
          side = code_adaptive(coder, near_side_, side, kMagnitudeCountLimit);
          distance = near_distance_.code(coder, distance);
          NMC_CHECK_STREAM(distance < kNearest, "4.4", "a border distance is too large");
          place = side == 0 ? border[next].next : previous;
          for (std::uint32_t step = 0; step < distance; ++step) {
            place = side == 0 ? border[place].next : border[place].previous;
          }
        } else {
          place = code_uniform(coder, place, static_cast<std::uint32_t>(border.size()));
          NMC_CHECK_STREAM(place < border.size(), "4.4", "a border edge that does not exist is named");
        }
        const std::uint32_t w = border[place].start;
        NMC_CHECK_STREAM(border[place].state != kGone && place != i && place != next && w != u && w != v,
                         "4.4", "an impossible place on the border is named");
        NMC_CHECK_STREAM(face_count < mesh.face_count, "4.4", "more faces than announced");
        add_face(u, v, w);
        const auto k = static_cast<std::uint32_t>(border.size());
        const std::uint32_t before = border[place].previous;
        if (!border.push_back({w, before, next, kOpen})) return no_memory();
        border[before].next = k;
        border[next].previous = k;
        border[i].next = place;
        border[place].previous = i;
        NMC_TRY(close_if_two(i));
        NMC_TRY(close_if_two(k));
      }
    }
  }
  NMC_CHECK_STREAM(vertex_count == mesh.vertex_count, "4.4", "fewer vertices than announced");
  return ok_status();
}

template <class Coder>
Status BaseMeshModel::code_coordinates(Coder& coder, Memory* memory, const LevelTopology& topology,
                                       BaseMesh& mesh) {
  using namespace base_mesh_internal;
  using coefficient_internal::code_adaptive;
  const std::uint32_t vertex_count = topology.vertex_count;
  if (!mesh.coordinates.resize(std::size_t{3} * vertex_count)) return no_memory();
  // Slots (face, corner) of each vertex, as lists.
  Array<std::uint32_t> first_slot(memory), next_slot(memory);
  if (!first_slot.assign(vertex_count, kNone) || !next_slot.resize(std::size_t{3} * topology.face_count)) {
    return no_memory();
  }
  for (std::uint32_t slot = 3 * topology.face_count; slot-- > 0;) {
    const std::uint32_t v = topology.face_vertices[slot];
    next_slot[slot] = first_slot[v];
    first_slot[v] = slot;
  }
  std::int32_t* const x = mesh.coordinates.data();

  // The share of the parallelograms in the prediction, in quarters; the rest is the mean of the neighbours.
  std::uint32_t share = parallelogram_share_;
  share = code_uniform(coder, share, 8);
  parallelogram_share_ = share;

  for (std::uint32_t v = 0; v < vertex_count; ++v) {
    // Neighbours with a lower number are known.
    std::int64_t neighbour_sum[3] = {0, 0, 0}, parallelogram_sum[3] = {0, 0, 0};
    std::int64_t neighbour_count = 0, parallelogram_count = 0;
    std::uint64_t spread = 0, spread_count = 0;
    for (std::uint32_t slot = first_slot[v]; slot != kNone; slot = next_slot[slot]) {
      const std::uint32_t face = slot / 3, k = slot % 3;
      const std::uint32_t a = topology.face_vertices[3 * face + (k + 1) % 3];
      const std::uint32_t b = topology.face_vertices[3 * face + (k + 2) % 3];
      if (a < v) {
        ++neighbour_count;
        for (std::uint32_t i = 0; i < 3; ++i) neighbour_sum[i] += x[3 * a + i];
      }
      if (b < v && topology.is_boundary(topology.face_edges[3 * face + (k + 1) % 3])) {
        ++neighbour_count;  // on a boundary no other face holds this neighbour as its `a`
        for (std::uint32_t i = 0; i < 3; ++i) neighbour_sum[i] += x[3 * b + i];
      }
      if (a >= v || b >= v) continue;
      const std::uint32_t across = topology.face_edges[3 * face + k];
      for (std::uint32_t i = 0; i < 3; ++i)
        spread += magnitude_u32(std::int64_t{x[3 * a + i]} - x[3 * b + i]);
      ++spread_count;
      const std::uint32_t left = topology.edge_faces[2 * across], right = topology.edge_faces[2 * across + 1];
      const std::uint32_t beyond = left == face ? right : left;
      if (beyond == kNone) continue;
      const std::uint32_t c = topology.opposite_vertex(across, beyond);
      if (c >= v) continue;
      ++parallelogram_count;
      for (std::uint32_t i = 0; i < 3; ++i)
        parallelogram_sum[i] += std::int64_t{x[3 * a + i]} + x[3 * b + i] - x[3 * c + i];
    }
    if (spread_count) last_spread_ = (spread + spread_count / 2) / spread_count;
    const int scale =
        bit_length(static_cast<std::uint32_t>(last_spread_ > 0xffffffffu ? 0xffffffffu : last_spread_));
    const int kind = parallelogram_count ? 0 : neighbour_count ? 1 : 2;
    for (std::uint32_t i = 0; i < 3; ++i) {
      std::int64_t prediction = 0, lean = 0;
      if (neighbour_count) {
        const std::int64_t mean = rounded_quotient(neighbour_sum[i], neighbour_count);
        prediction = mean;
        if (parallelogram_count) {
          const std::int64_t point = rounded_quotient(parallelogram_sum[i], parallelogram_count);
          prediction = rounded_quotient((4 - std::int64_t{share}) * mean + std::int64_t{share} * point, 4);
          lean = mean - point;
        }
      } else if (v > 0) {
        prediction = x[3 * (v - 1) + i];
      }
      const std::int64_t residual = std::int64_t{x[3 * v + i]} - prediction;
      // Bit length of the magnitude, counted downwards from just above the local edge length.
      const std::uint32_t magnitude = magnitude_u32(residual);
      const int top = kind == 2 ? 31 : scale + 1 > 30 ? 30 : scale + 1;
      int length = top;
      int step = 0;
      if (code_adaptive(coder, length_[kind][0], bit_length(magnitude) > top, kMagnitudeCountLimit)) {
        while (length < 31) {
          ++length;
          const int index = 33 + (length - top < 6 ? length - top : 6);
          if (!code_adaptive(coder, length_[kind][index], bit_length(magnitude) > length,
                             kMagnitudeCountLimit))
            break;
        }
        step = 33;
      } else {
        while (length > 0) {
          ++step;
          const int index = step < 32 ? step : 32;
          if (code_adaptive(coder, length_[kind][index], bit_length(magnitude) == length,
                            kMagnitudeCountLimit))
            break;
          --length;
        }
      }
      std::uint64_t decoded = 0;
      if (length > 0) {
        decoded = 1;
        for (int bit = length - 2; bit >= 0; --bit) {
          const int value = static_cast<int>((magnitude >> bit) & 1);
          const int coded = bit == length - 2 ? code_adaptive(coder, top_bit_[step < 39 ? step : 39], value,
                                                              kMagnitudeCountLimit)
                                              : coder.code(value, 32768);
          decoded = 2 * decoded + static_cast<std::uint64_t>(coded);
        }
      }
      std::int64_t value = prediction;
      if (decoded) {
        const int towards = lean > 0 ? 2 : lean < 0 ? 0 : 1;
        const int negative = code_adaptive(coder, sign_[kind][towards], residual < 0, kMagnitudeCountLimit);
        value += negative ? -static_cast<std::int64_t>(decoded) : static_cast<std::int64_t>(decoded);
      }
      NMC_CHECK_STREAM(value >= -kMaximumBaseCoordinate && value <= kMaximumBaseCoordinate, "4.6",
                       "a base vertex lies outside the grid");
      x[3 * v + i] = static_cast<std::int32_t>(value);
    }
  }
  return ok_status();
}

template <class Coder>
Status BaseMeshModel::code_corrections(Coder& coder, const std::int32_t* previous, std::uint32_t value_count,
                                       std::int32_t* values) {
  using namespace coefficient_internal;
  for (std::uint32_t i = 0; i < value_count; ++i) {
    const std::int64_t correction = std::int64_t{values[i]} - previous[i];
    const std::uint32_t magnitude =
        correction_.code(coder, static_cast<std::uint32_t>(correction < 0 ? -correction : correction));
    std::int64_t value = previous[i];
    if (magnitude) {
      const int negative = code_adaptive(coder, correction_sign_, correction < 0, kMagnitudeCountLimit);
      value += negative ? -static_cast<std::int64_t>(magnitude) : static_cast<std::int64_t>(magnitude);
    }
    NMC_CHECK_STREAM(value >= -kMaximumBaseCoordinate && value <= kMaximumBaseCoordinate, "4.6",
                     "a base vertex lies outside the grid");
    values[i] = static_cast<std::int32_t>(value);
  }
  return ok_status();
}

template <class Coder>
Status BaseMeshModel::code_creases(Coder& coder, Memory* memory, const LevelTopology& topology,
                                   BaseMesh& mesh) {
  using namespace coefficient_internal;
  if (!mesh.is_crease.resize(topology.edge_count)) return no_memory();
  // Creases run through vertices: the context is how many crease edges are already known at the two ends.
  Array<std::uint8_t> at_vertex(memory);
  if (!at_vertex.resize(topology.vertex_count)) return no_memory();
  for (std::uint32_t e = 0; e < topology.edge_count; ++e) {
    if (topology.is_boundary(e)) {
      mesh.is_crease[e] = 0;
      continue;
    }
    std::uint8_t& a = at_vertex[topology.edge_vertices[2 * e]];
    std::uint8_t& b = at_vertex[topology.edge_vertices[2 * e + 1]];
    const int context = (a == 1 ? 1 : 0) + (b == 1 ? 1 : 0) + (a > 1 && b > 1 ? 3 : 0);
    mesh.is_crease[e] = static_cast<std::uint8_t>(code_adaptive(
        coder, crease_[context > 3 ? 3 : context], mesh.is_crease[e] != 0, kMagnitudeCountLimit));
    if (mesh.is_crease[e]) {
      if (a < 3) ++a;
      if (b < 3) ++b;
    }
  }
  return ok_status();
}

}  // namespace nmc

#endif  // NMC_COMMON_BASE_MESH_CODER_INL_H_

// SPDX-License-Identifier: Apache-2.0
#include "libnmc/common/coded_mesh.h"

#include <cstring>
#include <type_traits>

#include "libnmc/common/hash.h"

namespace nmc {

CodedMesh::CodedMesh(Memory* memory, const Header* header)
    : memory_(memory),
      header_(header),
      base_(memory),
      ring_weights_(memory),
      vertex_values_(memory),
      positions_(memory),
      partition_(memory),
      region_scratch_(memory),
      next_layer_of_region_(memory) {
  for (LevelTopology& topology : topology_) topology.set_memory(memory);
  for (LevelCoefficients& coefficients : coefficients_) {
    coefficients.normal.set_memory(memory);
    coefficients.tangential.set_memory(memory);
  }
  for (CodedAttribute& attribute : attributes_) attribute = CodedAttribute(memory);
  for (int& layer : layer_of_level_) layer = -1;
  begin_layer();
}

void CodedMesh::begin_layer() {
  marked_base_layer_ = base_layer_;
  for (int level = 0; level < kMaximumLevelCount; ++level)
    marked_layer_of_level_[level] = layer_of_level_[level];
  is_region_changed_ = false;
  for (CodedAttribute& attribute : attributes_) attribute.begin_layer();
}

bool CodedMesh::roll_back_layer() {
  bool intact = base_layer_ == marked_base_layer_ && !correcting_ && !is_region_changed_;
  for (CodedAttribute& attribute : attributes_) attribute.roll_back_layer();
  for (int level = 0; level < kMaximumLevelCount; ++level) {
    if (layer_of_level_[level] == marked_layer_of_level_[level]) continue;
    if (marked_layer_of_level_[level] >= 0) intact = false;
    layer_of_level_[level] = marked_layer_of_level_[level];
    if (clean_level_ > level) clean_level_ = level;
  }
  return intact;
}

Status CodedMesh::set_base_topology() {
  NMC_TRY(build_base_topology(base_.face_vertices.data(), base_.face_count, base_.vertex_count, memory_,
                              topology_[0]));
  NMC_TRY(ring_weights_.build(topology_[0]));
  topology_count_ = 1;
  last_is_faces_only_ = false;
  return ok_status();
}

Status CodedMesh::ensure_topology(int level, bool faces_only) {
  if (level < 0 || level > kMaximumLevelCount || topology_count_ == 0) {
    return NMC_ERROR(kState, nullptr, "the level is not there yet");
  }
  const bool needs_edges_of_last = level >= topology_count_ || (level == topology_count_ - 1 && !faces_only);
  if (needs_edges_of_last && last_is_faces_only_) {
    const int last = topology_count_ - 1;
    NMC_TRY(subdivide(topology_[last - 1], false, topology_[last]));
    last_is_faces_only_ = false;
  }
  while (topology_count_ <= level) {
    const bool only = faces_only && topology_count_ == level;
    NMC_TRY(subdivide(topology_[topology_count_ - 1], only, topology_[topology_count_]));
    last_is_faces_only_ = only;
    ++topology_count_;
  }
  return ok_status();
}

Status CodedMesh::begin_level(int layer, int level, LevelCoefficients& previous, bool& has_previous) {
  NMC_CHECK_STREAM(level >= 0 && level < header_->level_count && layer < header_->quality_layer_count, "5.3",
                   "a level or layer that the header does not announce");
  NMC_CHECK_STREAM(base_layer_ >= 0 && layer == layer_of_level_[level] + 1 &&
                       (level == 0 || layer_of_level_[level - 1] >= 0) &&
                       (header_->region_count == 0 || level < header_->region_level),
                   "4.3", "a level comes out of order");
  NMC_TRY(ensure_topology(level, false));
  has_previous = layer > 0;
  if (!has_previous) return ok_status();
  // What the level had moves to `previous`; all of it comes anew.
  correcting_ = true;
  LevelCoefficients& current = coefficients_[level];
  previous.normal.swap(current.normal);
  previous.tangential.swap(current.tangential);
  scale(layer, previous);
  return ok_status();
}

NMC_SELDOM void CodedMesh::scale(int layer, LevelCoefficients& coefficients) const {
  const std::int64_t ratio = header_->layer_ratio[layer];
  for (std::int32_t& value : coefficients.normal) value = held_coefficient(ratio * value);
  for (TangentialCoefficient& t : coefficients.tangential) {
    t.along = held_coefficient(ratio * t.along);
    t.across = held_coefficient(ratio * t.across);
  }
}

Status CodedMesh::end_level(int layer, int level) {
  if (level + 1 < header_->level_count) {  // contexts of the next level look at them
    const LevelTopology& topology = topology_[level];
    const std::size_t needed = std::size_t{topology.vertex_count} + topology.edge_count;
    if (vertex_values_.size() < needed && !vertex_values_.resize_unset(needed)) return no_memory();
    std::memcpy(vertex_values_.data() + topology.vertex_count, coefficients_[level].normal.data(),
                topology.edge_count * sizeof(std::int32_t));
  }
  layer_of_level_[level] = layer;
  correcting_ = false;
  if (clean_level_ > level) clean_level_ = level;
  return ok_status();
}

NMC_SELDOM Status CodedMesh::ensure_partition() {
  if (header_->region_count == 0 || topology_count_ == 0) {
    return NMC_ERROR(kState, nullptr, "there are no regions, or none yet");
  }
  if (!next_layer_of_region_.empty()) return ok_status();
  NMC_TRY(partition_.build(topology_[0], header_->region_count, memory_));
  return next_layer_of_region_.resize(header_->region_count) ? ok_status() : no_memory();
}

NMC_SELDOM Status CodedMesh::begin_region(int layer, int region, RegionCoder& coding) {
  NMC_CHECK_STREAM(base_layer_ >= 0, "4.3", "coefficients come before the base mesh");
  NMC_TRY(ensure_partition());
  const int first = header_->region_level, reached = layer_of_level_[first];
  NMC_CHECK_STREAM(layer_of_level_[first - 1] >= 0 && layer == static_cast<int>(next_layer_of_region_[static_cast<std::size_t>(region)]) && layer >= reached &&
                       layer <= reached + 1,
                   "4.3", "a region comes out of order");
  static_assert(std::is_trivially_copyable_v<CoefficientModel>);
  if (!coding.shared_states_.resize_unset(sizeof coefficient_model_ / sizeof(std::uint32_t))) return no_memory();
  std::memcpy(coding.shared_states_.data(), &coefficient_model_, sizeof coefficient_model_);
  coding.region_ = region;
  coding.layer_ = layer;
  return ok_status();
}

NMC_SELDOM Status CodedMesh::walk_region_to(int level, RegionCoder& coding) {
  RegionLevel& region = coding.level_;
  const auto region_number = static_cast<std::uint32_t>(coding.region_);
  Array<std::int32_t>& vertex_values = coding.vertex_values_;
  if (coding.number_ < 0) {
    NMC_TRY(region.extract(topology_[0], partition_, region_number, region_scratch_));
    const std::uint32_t vertex_count = region.topology().vertex_count;
    if (!vertex_values.resize(std::size_t{vertex_count} + region.topology().edge_count)) return no_memory();
    for (std::uint32_t e = 0; e < region.topology().edge_count; ++e) {
      const bool is_foreign = region.odd_edges[2 * e] == kNone;
      vertex_values[vertex_count + e] = is_foreign ? 0 : coefficients_[0].normal[region.edges[e]];
    }
    coding.number_ = 1;
  }
  for (; coding.number_ < level; ++coding.number_) {
    NMC_TRY(exchange_region(coding, coding.values_, coefficients_[coding.number_], nullptr));
    const std::size_t known = vertex_values.size(), added = coding.values_.normal.size();
    if (!vertex_values.resize_unset(known + added)) return no_memory();
    std::memcpy(vertex_values.data() + known, coding.values_.normal.data(), added * sizeof(std::int32_t));
    NMC_TRY(region.split(partition_, region_number));
  }
  const LevelTopology& part = region.topology();
  LevelTopology& fine = coding.fine_;
  fine.edge_count = 2 * part.edge_count + 3 * part.face_count;
  fine.edge_is_curve.clear();
  if (part.has_curves() && !fine.edge_is_curve.resize(fine.edge_count)) return no_memory();
  for (std::uint32_t e = 0; part.has_curves() && e < 2 * part.edge_count; ++e)
    fine.edge_is_curve[e] = part.edge_is_curve[e / 2];
  return ok_status();
}

NMC_SELDOM Status CodedMesh::begin_region_level(int level, RegionCoder& coding, std::uint64_t& value_count) {
  NMC_TRY(walk_region_to(level, coding));
  value_count = std::uint64_t{coding.fine_.edge_count} + coefficients_[level].tangential.size();
  return ok_status();
}

NMC_SELDOM Status CodedMesh::open_region_level(RegionCoder& coding) {
  const int level = coding.number_;
  LevelCoefficients& whole = coefficients_[level];
  if (layer_of_level_[level] < 0) {
    const std::size_t count = 2 * std::size_t{coding.level_.whole_edge_count} +
                              3 * (std::size_t{header_->base_face_count} << (2 * (level - 1)));
    whole.normal.clear();
    whole.tangential.clear();
    if (!whole.normal.resize(count)) return no_memory();
    layer_of_level_[level] = 0;
  } else if (layer_of_level_[level] < coding.layer_) {
    is_region_changed_ = true;
    scale(coding.layer_, whole);
    // From here on all regions are in the finer steps, with the values that they had.
    layer_of_level_[level] = coding.layer_;
  }
  return ok_status();
}

NMC_SELDOM Status CodedMesh::exchange_region(const RegionCoder& coding, LevelCoefficients& part,
                                             const LevelCoefficients& from, LevelCoefficients* to) const {
  const Array<std::uint32_t>& numbers = coding.level_.odd_edges;
  // Both lists are in order of edge, in either numbering. Into the whole they are merged, and what the region had
  // goes; out of it the region's own entries are looked up.
  const std::size_t from_count = from.tangential.size(), part_count = to ? part.tangential.size() : 0;
  Array<TangentialCoefficient> list(memory_);
  if (!list.reserve(from_count + part_count) || !part.normal.resize(numbers.size())) return no_memory();
  std::size_t i = 0, j = 0;
  const auto take = [&](const TangentialCoefficient& t, std::uint32_t edge) {
    static_cast<void>(list.push_back({edge, t.along, t.across}));  // room was reserved
  };
  for (std::size_t e = 0; e <= numbers.size(); ++e) {
    const bool is_end = e == numbers.size();
    const std::uint32_t number = is_end ? kNone : numbers[e];
    if (!is_end && number == kNone) {
      part.normal[e] = 0;
      continue;
    }
    for (; i < from_count && from.tangential[i].edge < number; ++i)
      if (to) take(from.tangential[i], from.tangential[i].edge);
    if (is_end) break;
    if (i < from_count && from.tangential[i].edge == number) {
      if (!to) take(from.tangential[i], static_cast<std::uint32_t>(e));
      ++i;
    }
    if (!to) {
      part.normal[e] = from.normal[number];
      continue;
    }
    to->normal[number] = part.normal[e];
    if (j < part_count && part.tangential[j].edge == e) take(part.tangential[j++], number);
  }
  (to ? to->tangential : part.tangential).swap(list);
  return ok_status();
}

NMC_SELDOM Status CodedMesh::put_region(const RegionCoder& coding, LevelCoefficients& part) {
  LevelCoefficients& whole = coefficients_[coding.number_];
  is_region_changed_ = true;
  if (clean_level_ > coding.number_) clean_level_ = coding.number_;
  return exchange_region(coding, part, whole, &whole);
}

void CodedMesh::end_region(const RegionCoder& coding) {
  ++next_layer_of_region_[static_cast<std::size_t>(coding.region_)];
  std::memcpy(static_cast<void*>(&coefficient_model_), coding.shared_states_.data(), sizeof coefficient_model_);
}

LevelQuantizer CodedMesh::current_quantizer(int level) const {
  const int layer = layer_of_level_[level];
  return header_->quantizer(level, layer < 0 ? 0 : layer);
}

Status CodedMesh::update_positions(int level, StopRequest stop, [[maybe_unused]] TaskRunner runner) {
  if (base_layer_ < 0) return NMC_ERROR(kState, nullptr, "the base mesh is not there yet");
  if (clean_level_ >= level) return ok_status();
  if (level > 0) NMC_TRY(ensure_topology(level - 1, false));
  const std::size_t vertex_count =
      level == 0 ? topology_[0].vertex_count
                 : std::size_t{topology_[level - 1].vertex_count} + topology_[level - 1].edge_count;
  if (positions_.size() < vertex_count && !positions_.resize_unset(vertex_count)) return no_memory();
  if (clean_level_ < 0) {
    const double step = header_->grid_step();
    const std::int64_t ratio = header_->ratio_after(base_layer_);
    for (std::uint32_t v = 0; v < base_.vertex_count; ++v)
      for (int k = 0; k < 3; ++k)
        positions_[v][k] =
            static_cast<double>(header_->origin[k] + ratio * base_.coordinates[3 * v + k]) * step;
    clean_level_ = 0;
  }
  constexpr std::uint32_t kEdgesPerPiece = 1 << 14;
  for (int l = clean_level_; l < level; ++l) {
    const std::uint32_t edge_count = topology_[l].edge_count;
    const std::uint32_t piece_count = (edge_count + kEdgesPerPiece - 1) / kEdgesPerPiece;
    auto make_piece = [this, l, edge_count](std::uint32_t piece) {
      const std::uint32_t first = piece * kEdgesPerPiece;
      const std::uint32_t last = edge_count - first > kEdgesPerPiece ? first + kEdgesPerPiece : edge_count;
      update_odd_vertices(l, first, last);
    };
    std::uint32_t next = 0;
#ifndef NMC_WITHOUT_THREADS
    // Pieces read vertices of coarser levels and write their own.
    if (runner.run_tasks && piece_count > 1) {
      using MakePiece = decltype(make_piece);
      NMC_TRY(stop.check());
      runner.run_tasks(
          runner.user,
          [](void* context, std::uint32_t piece) { (*static_cast<MakePiece*>(context))(piece); },
          &make_piece, piece_count);
      next = piece_count;
    }
#endif
    for (; next < piece_count; ++next) {
      NMC_TRY(stop.check());
      make_piece(next);
    }
    clean_level_ = l + 1;
  }
  return ok_status();
}

void CodedMesh::update_odd_vertices(int level, std::uint32_t first, std::uint32_t last) {
  const LevelCoefficients* coefficients = layer_of_level_[level] < 0 ? nullptr : &coefficients_[level];
  if (level > 0) {
    reconstruct_odd_vertices_of_split(topology_[level - 1], topology_[level], ring_weights_, current_quantizer(level),
                                      coefficients, first, last, positions_.data());
  } else {
    reconstruct_odd_vertices(topology_[level], ring_weights_, current_quantizer(level), coefficients, first, last,
                             positions_.data());
  }
}

Status CodedMesh::update_attribute(int index, int level, StopRequest stop) {
  CodedAttribute& attribute = attributes_[index];
  if (attribute.finest_known_level() < 0)
    return NMC_ERROR(kState, nullptr, "the attribute is not there yet");
  for (int l = attribute.finest_known_level() + 1; l <= level; ++l) {
    NMC_TRY(ensure_topology(l - 1, false));
    NMC_TRY(attribute.predict_level(header_->attributes[index], l, topology_[l - 1], stop));
  }
  return ok_status();
}

std::uint64_t CodedMesh::state_hash() const {
  Hash64 hash;
  hash.add_u32(base_.vertex_count);
  hash.add_u32(base_.face_count);
  for (const std::uint32_t v : base_.face_vertices) hash.add_u32(v);
  for (const std::uint8_t c : base_.is_crease) hash.add_u32(c);
  for (const std::int32_t x : base_.coordinates) hash.add_i32(x);
  for (int level = 0; level < header_->level_count && layer_of_level_[level] >= 0; ++level) {
    hash.add_i32(layer_of_level_[level]);
    for (const std::int32_t c : coefficients_[level].normal) hash.add_i32(c);
    for (const TangentialCoefficient& t : coefficients_[level].tangential) {
      hash.add_u32(t.edge);
      hash.add_i32(t.along);
      hash.add_i32(t.across);
    }
  }
  return hash.value();
}

std::uint64_t CodedMesh::position_hash(int level) const {
  Hash64 hash;
  const std::size_t count =
      level == 0 ? topology_[0].vertex_count
                 : std::size_t{topology_[level - 1].vertex_count} + topology_[level - 1].edge_count;
  for (std::size_t v = 0; v < count; ++v) hash.add_position(positions_[v]);
  return hash.value();
}

}  // namespace nmc

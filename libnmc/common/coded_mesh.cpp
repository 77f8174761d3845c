// SPDX-License-Identifier: Apache-2.0
#include "libnmc/common/coded_mesh.h"

#include <cstring>

#include "libnmc/common/hash.h"

namespace nmc {

CodedMesh::CodedMesh(Memory* memory, const Header* header)
    : memory_(memory),
      header_(header),
      base_(memory),
      ring_weights_(memory),
      vertex_values_(memory),
      positions_(memory) {
  for (LevelTopology& topology : topology_) topology = LevelTopology(memory);
  for (LevelCoefficients& coefficients : coefficients_) coefficients = LevelCoefficients(memory);
  for (CodedAttribute& attribute : attributes_) attribute = CodedAttribute(memory);
  for (int& layer : layer_of_level_) layer = -1;
  begin_layer();
}

void CodedMesh::begin_layer() {
  marked_base_layer_ = base_layer_;
  for (int level = 0; level < kMaximumLevelCount; ++level)
    marked_layer_of_level_[level] = layer_of_level_[level];
  for (CodedAttribute& attribute : attributes_) attribute.begin_layer();
}

bool CodedMesh::roll_back_layer() {
  bool intact = base_layer_ == marked_base_layer_ && !correcting_;
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
    return {StatusCode::kState, nullptr, "the level is not there yet"};
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
                       (level == 0 || layer_of_level_[level - 1] >= 0),
                   "4.3", "a level comes out of order");
  NMC_TRY(ensure_topology(level, false));
  has_previous = layer > 0;
  if (!has_previous) return ok_status();
  correcting_ = true;
  const LevelCoefficients& current = coefficients_[level];
  if (!previous.normal.resize(current.normal.size()) ||
      !previous.tangential.resize(current.tangential.size())) {
    return no_memory();
  }
  const std::int64_t ratio = header_->layer_ratio[layer];
  const auto scaled = [&](std::int32_t value) {
    const std::int64_t product = ratio * value;
    return static_cast<std::int32_t>(product > kMaximumMagnitude    ? kMaximumMagnitude
                                     : product < -kMaximumMagnitude ? -kMaximumMagnitude
                                                                    : product);
  };
  for (std::size_t i = 0; i < current.normal.size(); ++i) previous.normal[i] = scaled(current.normal[i]);
  for (std::size_t i = 0; i < current.tangential.size(); ++i) {
    const TangentialCoefficient& t = current.tangential[i];
    previous.tangential[i] = {t.edge, scaled(t.along), scaled(t.across)};
  }
  return ok_status();
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

LevelQuantizer CodedMesh::current_quantizer(int level) const {
  const int layer = layer_of_level_[level];
  return header_->quantizer(level, layer < 0 ? 0 : layer);
}

Status CodedMesh::update_positions(int level, StopRequest stop) {
  if (base_layer_ < 0) return {StatusCode::kState, nullptr, "the base mesh is not there yet"};
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
  constexpr std::uint32_t kEdgesPerPiece = 1 << 16;
  for (int l = clean_level_; l < level; ++l) {
    const std::uint32_t edge_count = topology_[l].edge_count;
    for (std::uint32_t first = 0; first < edge_count; first += kEdgesPerPiece) {
      NMC_TRY(stop.check());
      const std::uint32_t last = edge_count - first > kEdgesPerPiece ? first + kEdgesPerPiece : edge_count;
      const LevelCoefficients* coefficients = layer_of_level_[l] < 0 ? nullptr : &coefficients_[l];
      if (l > 0) {
        reconstruct_odd_vertices_of_split(topology_[l - 1], topology_[l], ring_weights_, current_quantizer(l),
                                          coefficients, first, last, positions_.data());
      } else {
        reconstruct_odd_vertices(topology_[l], ring_weights_, current_quantizer(l), coefficients, first, last,
                                 positions_.data());
      }
    }
    clean_level_ = l + 1;
  }
  return ok_status();
}

Status CodedMesh::update_attribute(int index, int level, StopRequest stop) {
  CodedAttribute& attribute = attributes_[index];
  if (attribute.finest_known_level() < 0)
    return {StatusCode::kState, nullptr, "the attribute is not there yet"};
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

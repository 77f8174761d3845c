// SPDX-License-Identifier: Apache-2.0
// The integers of a stream and what follows from them: the state that encoder and decoder walk through in
// step.
//
// The coding functions are templates over the coder, as in coefficient_coder.h; positions come from
// reconstruct.h. A decoder is this class plus parsing, an encoder this class plus decisions.
#ifndef NMC_COMMON_CODED_MESH_H_
#define NMC_COMMON_CODED_MESH_H_

#include <cstdint>

#include "libnmc/common/base_mesh_coder.h"
#include "libnmc/common/coded_attribute.h"
#include "libnmc/common/coefficient_coder.h"
#include "libnmc/common/format.h"
#include "libnmc/common/memory.h"
#include "libnmc/common/reconstruct.h"
#include "libnmc/common/region.h"
#include "libnmc/common/status.h"
#include "libnmc/common/stop_request.h"
#include "libnmc/common/task_runner.h"

namespace nmc {

class CodedMesh {
 public:
  /// `memory` and `header` must outlive the object.
  CodedMesh(Memory* memory, const Header* header);

  /// Base mesh: connectivity, creases, coordinates of quality layer 0. `lookup` and `seeds`: see
  /// BaseMeshModel; null when decoding. An encoder sets `base()` coordinates by `coordinates_of_old`, 3 per
  /// vertex of its own numbering, and reads the new numbering from `old_index`.
  template <class Coder>
  NMC_SELDOM Status code_base(Coder& coder, const FaceLookup* lookup, const std::uint32_t* seeds,
                              const std::int32_t* coordinates_of_old, const std::uint8_t* creases_by_edge,
                              Array<std::uint32_t>* old_index);
  /// The base coordinates of quality layer `layer` >= 1. Encoders give the new ones, in the new numbering.
  template <class Coder>
  NMC_SELDOM Status code_base_correction(Coder& coder, int layer, const std::int32_t* coordinates);
  /// The odd vertices of level `level` in quality layer `layer`. Encoders give the target.
  template <class Coder>
  Status code_level(Coder& coder, int layer, int level, const LevelCoefficients* target);

  /// The same for one region: begin_region(), for each level of the header's regions begin_region_level() and
  /// code_region_level(), end_region(). The region's states start as those of all are now.
  class RegionCoder;
  /// `layer` and `region` must be of the header.
  Status begin_region(int layer, int region, RegionCoder& coding);
  /// Tells how many values are to be dealt with.
  Status begin_region_level(int level, RegionCoder& coding, std::uint64_t& value_count);
  /// `target` is that of the whole level; null when decoding.
  template <class Coder>
  Status code_region_level(Coder& coder, RegionCoder& coding, const LevelCoefficients* target);
  void end_region(const RegionCoder& coding);
  /// Which base face lies in which region. Needs the base mesh and a header with regions.
  Status ensure_partition();
  const RegionPartition& partition() const { return partition_; }

  /// The values that `level` of attribute `index` adds, which must be its next one: see CodedAttribute, also
  /// for `choose`. Needs the base mesh, but no level of the geometry.
  template <class Coder, class Choose>
  Status code_attribute(Coder& coder, int index, int level, const Choose& choose);

  /// Marks the present state as one to go back to.
  void begin_layer();
  /// Takes back what was coded since begin_layer(). False when older values were corrected in place, so that
  /// they are lost; the mesh is then of no use.
  bool roll_back_layer();

  /// Share of parallelograms in the prediction of base vertices, in quarters. Encoders only, before
  /// code_base.
  void set_parallelogram_share(std::uint32_t quarters) { base_model_.set_parallelogram_share(quarters); }

  bool has_base() const { return base_layer_ >= 0; }
  int base_layer() const { return base_layer_; }
  /// Quality layer reached by a level; -1 when nothing of it has been coded.
  int layer_of_level(int level) const { return layer_of_level_[level]; }
  const BaseMesh& base() const { return base_; }
  const LevelCoefficients& coefficients(int level) const { return coefficients_[level]; }

  /// Connectivity of `level`, building what is missing; `faces_only` levels have no edges.
  Status ensure_topology(int level, bool faces_only);
  const LevelTopology& topology(int level) const { return topology_[level]; }

  /// Brings positions up to date for all vertices of `level`. Work is proportional to what has changed since
  /// the last call.
  /// The vertices of a level are made in pieces, on several threads where `runner` has them.
  Status update_positions(int level, StopRequest stop = {}, TaskRunner runner = {});
  /// Brings the values of attribute `index` up to date for all vertices of `level`; kState before any is
  /// coded.
  Status update_attribute(int index, int level, StopRequest stop = {});
  const CodedAttribute& attribute(int index) const { return attributes_[index]; }
  const Vec3* positions() const { return positions_.data(); }
  /// Steps of the odd vertices of `level` in the quality layer they have reached.
  LevelQuantizer current_quantizer(int level) const;
  const RingWeights& ring_weights() const { return ring_weights_; }

  /// Hash of all integers received so far (spec 9.1).
  std::uint64_t state_hash() const;
  /// Hash of the positions of the vertices of `level`, which must be up to date (spec 9.2).
  std::uint64_t position_hash(int level) const;

 private:
  Status begin_level(int layer, int level, LevelCoefficients& previous, bool& has_previous);
  Status end_level(int layer, int level);
  /// Brings coefficients of the layer before `layer` to its steps.
  void scale(int layer, LevelCoefficients& coefficients) const;
  /// Copies the integers of the region's own edges out of those of the whole, `from`, or into them where `to` is
  /// given, which then is the same level.
  Status exchange_region(const RegionCoder& coding, LevelCoefficients& part, const LevelCoefficients& from,
                         LevelCoefficients* to) const;
  Status put_region(const RegionCoder& coding, LevelCoefficients& part);
  /// Builds the region's connectivity up to what level `level` needs.
  Status walk_region_to(int level, RegionCoder& coding);
  /// Makes room for the level's integers, or brings them to the steps of the region's layer.
  Status open_region_level(RegionCoder& coding);
  Status set_base_topology();
  /// The odd vertices of the edges [first, last) of `level`.
  void update_odd_vertices(int level, std::uint32_t first, std::uint32_t last);
  void base_changed() { clean_level_ = -1; }

  Memory* memory_;
  const Header* header_;
  BaseMeshModel base_model_;
  CoefficientModel coefficient_model_;
  BaseMesh base_;
  LevelTopology topology_[kMaximumLevelCount + 1];
  RingWeights ring_weights_;
  LevelCoefficients coefficients_[kMaximumLevelCount];
  CodedAttribute attributes_[kMaximumAttributeCount];
  Array<std::int32_t> vertex_values_;  // normal coefficient with which each vertex was inserted
  Array<Vec3> positions_;
  int topology_count_ = 0;  // levels with connectivity
  bool last_is_faces_only_ = false;
  int base_layer_ = -1;
  int layer_of_level_[kMaximumLevelCount];
  int clean_level_ = -1;        // positions are up to date for the vertices of this level
  int marked_base_layer_ = -1;  // as they were at begin_layer()
  bool correcting_ = false;     // values of an earlier layer are being overwritten
  int marked_layer_of_level_[kMaximumLevelCount];
  RegionPartition partition_;
  Array<std::uint32_t> region_scratch_;
  bool is_region_changed_ = false;  // integers that were there have been written over since begin_layer()
  Array<std::uint32_t> next_layer_of_region_;
};

/// A region's chunk while it is coded: the region as a mesh of its own.
class CodedMesh::RegionCoder {
 public:
  explicit RegionCoder(Memory* memory)
      : shared_states_(memory), level_(memory), fine_(memory), values_(memory), vertex_values_(memory) {}

 private:
  friend class CodedMesh;
  Array<std::uint32_t> shared_states_;  // the bytes of the mesh's CoefficientModel as it was before
  RegionLevel level_;              // the level below the one that is coded
  LevelTopology fine_;             // its split: counts and curve edges
  LevelCoefficients values_;       // by the edges of the split
  Array<std::int32_t> vertex_values_;
  int region_ = 0, layer_ = 0;
  int number_ = -1;  // the level that is coded; -1: none yet
};

// ---- implementation ----

template <class Coder>
Status CodedMesh::code_base(Coder& coder, const FaceLookup* lookup, const std::uint32_t* seeds,
                            const std::int32_t* coordinates_of_old, const std::uint8_t* creases_by_edge,
                            Array<std::uint32_t>* old_index) {
  NMC_CHECK_STREAM(base_layer_ < 0, "4.3", "the base mesh comes twice");
  base_.vertex_count = header_->base_vertex_count;
  base_.face_count = header_->base_face_count;
  Array<std::uint32_t> unused(memory_);
  Array<std::uint32_t>& order = old_index ? *old_index : unused;
  NMC_TRY(base_model_.code_connectivity(coder, memory_, lookup, seeds, base_, order));
  NMC_TRY(set_base_topology());
  if (header_->has_creases) {
    if constexpr (!Coder::kDecodes) {
      if (!base_.is_crease.resize(topology_[0].edge_count)) return no_memory();
      for (std::uint32_t e = 0; e < topology_[0].edge_count; ++e) base_.is_crease[e] = creases_by_edge[e];
    }
    NMC_TRY(base_model_.code_creases(coder, memory_, topology_[0], base_));
    NMC_TRY(set_creases(base_.is_crease.data(), topology_[0]));
  }
  if (!base_.coordinates.resize(std::size_t{3} * base_.vertex_count)) return no_memory();
  if constexpr (!Coder::kDecodes) {
    for (std::uint32_t v = 0; v < base_.vertex_count; ++v)
      for (std::uint32_t k = 0; k < 3; ++k)
        base_.coordinates[3 * v + k] = coordinates_of_old[3 * order[v] + k];
  }
  NMC_TRY(base_model_.code_coordinates(coder, memory_, topology_[0], base_));
  if (!vertex_values_.resize(base_.vertex_count)) return no_memory();
  base_layer_ = 0;
  base_changed();
  return ok_status();
}

template <class Coder>
Status CodedMesh::code_base_correction(Coder& coder, int layer, const std::int32_t* coordinates) {
  NMC_CHECK_STREAM(base_layer_ >= 0 && layer == base_layer_ + 1 && layer < header_->quality_layer_count,
                   "4.3", "a base correction comes out of order");
  Array<std::int32_t> previous(memory_);
  const std::size_t count = base_.coordinates.size();
  if (!previous.resize(count)) return no_memory();
  for (std::size_t i = 0; i < count; ++i) {
    const std::int64_t scaled = std::int64_t{base_.coordinates[i]} * header_->layer_ratio[layer];
    NMC_CHECK_STREAM(scaled >= -kMaximumBaseCoordinate && scaled <= kMaximumBaseCoordinate, "4.6",
                     "a base vertex lies outside the grid");
    previous[i] = static_cast<std::int32_t>(scaled);
  }
  correcting_ = true;
  if constexpr (!Coder::kDecodes) {
    for (std::size_t i = 0; i < count; ++i) base_.coordinates[i] = coordinates[i];
  }
  NMC_TRY(base_model_.code_corrections(coder, previous.data(), static_cast<std::uint32_t>(count),
                                       base_.coordinates.data()));
  correcting_ = false;
  base_layer_ = layer;
  base_changed();
  return ok_status();
}

template <class Coder>
Status CodedMesh::code_level(Coder& coder, int layer, int level, const LevelCoefficients* target) {
  LevelCoefficients previous(memory_);
  bool has_previous = false;
  NMC_TRY(begin_level(layer, level, previous, has_previous));
  LevelCoefficients& current = coefficients_[level];
  if constexpr (!Coder::kDecodes) {
    if (!current.normal.resize(target->normal.size()) ||
        !current.tangential.resize(target->tangential.size())) {
      return no_memory();
    }
    for (std::size_t i = 0; i < target->normal.size(); ++i) current.normal[i] = target->normal[i];
    for (std::size_t i = 0; i < target->tangential.size(); ++i) current.tangential[i] = target->tangential[i];
  }
  NMC_TRY(coefficient_model_.code_level(coder, memory_, level, level > 0 ? &topology_[level - 1] : nullptr,
                                        topology_[level], vertex_values_.data(),
                                        has_previous ? &previous : nullptr, current));
  return end_level(layer, level);
}

template <class Coder>
Status CodedMesh::code_region_level(Coder& coder, RegionCoder& coding, const LevelCoefficients* target) {
  LevelCoefficients previous(memory_);
  const bool has_previous = coding.layer_ > 0;
  NMC_TRY(open_region_level(coding));
  if (has_previous) NMC_TRY(exchange_region(coding, previous, coefficients_[coding.number_], nullptr));
  if constexpr (!Coder::kDecodes) NMC_TRY(exchange_region(coding, coding.values_, *target, nullptr));
  NMC_TRY(coefficient_model_.code_level(coder, memory_, coding.number_, &coding.level_.topology(), coding.fine_,
                                      coding.vertex_values_.data(), has_previous ? &previous : nullptr,
                                      coding.values_, coding.level_.odd_edges.data()));
  return put_region(coding, coding.values_);
}

template <class Coder, class Choose>
Status CodedMesh::code_attribute(Coder& coder, int index, int level, const Choose& choose) {
  NMC_CHECK_STREAM(index >= 0 && index < header_->attribute_count && level >= 0 &&
                       level <= header_->attributes[index].finest_level,
                   "10.3", "a level or attribute that the header does not announce");
  const AttributeDescriptor& descriptor = header_->attributes[index];
  if (level == 0) return attributes_[index].code_base(coder, descriptor, memory_, topology_[0], choose);
  NMC_CHECK_STREAM(level == attributes_[index].next_level(), "10.3",
                   "a level of an attribute comes out of order");
  NMC_TRY(ensure_topology(level - 1, false));
  return attributes_[index].code_level(coder, descriptor, level, topology_[level - 1], choose);
}

}  // namespace nmc

#endif  // NMC_COMMON_CODED_MESH_H_

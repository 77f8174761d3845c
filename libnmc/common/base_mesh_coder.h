// SPDX-License-Identifier: Apache-2.0
// The base mesh: connectivity by cut-border growth, then vertices predicted from their neighbours
// (spec 4.4, 4.6).
//
// Based on: S. Gumhold, W. Strasser. Real time compression of triangle mesh connectivity. SIGGRAPH 1998 (the
// border and its symbols; any genus, boundary and number of components); D. Cohen-Or, R. Cohen, R. Irony.
// Multi-way geometry encoding. 2002 (average of several parallelograms).
//
// The decoder's loop and the encoder's are the same template: at every open border edge, the gate, a symbol
// tells what the next face's third corner is. A decoder learns it from the bits, an encoder from the mesh.
#ifndef NMC_COMMON_BASE_MESH_CODER_H_
#define NMC_COMMON_BASE_MESH_CODER_H_

#include <cstdint>

#include "libnmc/common/coefficient_coder.h"
#include "libnmc/common/memory.h"
#include "libnmc/common/status.h"

namespace nmc {

/// Largest coordinate of a base vertex on its grid (spec 8).
inline constexpr std::int32_t kMaximumBaseCoordinate = (1 << 28) - 1;

/// The base mesh as coded: faces over vertices, vertices on an integer grid.
struct BaseMesh {
  explicit BaseMesh(Memory* memory = nullptr)
      : face_vertices(memory), coordinates(memory), is_crease(memory) {}
  std::uint32_t vertex_count = 0;
  std::uint32_t face_count = 0;
  Array<std::uint32_t> face_vertices;  // 3 per face
  Array<std::int32_t> coordinates;     // 3 per vertex
  Array<std::uint8_t> is_crease;       // 1 per edge of level 0, or empty
};

/// Gives the third corner of the face that holds the directed edge (u, v), or kNone on a boundary. Encoders
/// only.
class FaceLookup {
 public:
  virtual std::uint32_t third_corner(std::uint32_t u, std::uint32_t v) const = 0;

 protected:
  ~FaceLookup() = default;
};

class BaseMeshModel {
 public:
  /// Starts trained (spec appendix D).
  BaseMeshModel();
  /// Knows nothing: where the training starts from.
  void reset_untrained();
  /// As in CoefficientModel.
  template <class Visit>
  void visit_trained_states(Visit&& visit);
  template <class Visit>
  void visit_trained_mixers(Visit&& visit) {
    visit(kMixIsNew, 3, is_new_mixer_);
  }

  /// Codes connectivity. Counts are known to both sides. The decoder fills mesh.face_vertices; the encoder
  /// passes `lookup` and gets in `old_index` which of its vertices became vertex 0, 1, ... and in
  /// mesh.face_vertices the faces as the decoder will see them. Fails with kCorrupt on impossible symbols.
  template <class Coder>
  NMC_SELDOM Status code_connectivity(Coder& coder, Memory* memory, const FaceLookup* lookup,
                           const std::uint32_t* component_seeds, BaseMesh& mesh,
                           Array<std::uint32_t>& old_index);

  /// Codes the coordinates of all vertices of `topology`, built from mesh.face_vertices. Encoders choose the
  /// share of the parallelograms in the prediction (0 ... 7 quarters) beforehand; the stream holds it.
  void set_parallelogram_share(std::uint32_t quarters) { parallelogram_share_ = quarters; }
  template <class Coder>
  NMC_SELDOM Status code_coordinates(Coder& coder, Memory* memory, const LevelTopology& topology, BaseMesh& mesh);

  /// Codes corrections to the coordinates: value = previous * ratio + correction. `previous` is already
  /// multiplied.
  template <class Coder>
  NMC_SELDOM Status code_corrections(Coder& coder, const std::int32_t* previous, std::uint32_t value_count,
                          std::int32_t* values);

  /// Codes one crease bit per inner edge of level 0.
  template <class Coder>
  NMC_SELDOM Status code_creases(Coder& coder, Memory* memory, const LevelTopology& topology, BaseMesh& mesh);

 private:
  static constexpr int kDegreeClasses = 10;
  AdaptiveBit is_new_[kDegreeClasses][kDegreeClasses], is_new_by_u_[kDegreeClasses],
      is_new_by_v_[kDegreeClasses];
  MixerWeights is_new_mixer_;
  AdaptiveBit is_left_[kDegreeClasses], is_right_[kDegreeClasses], is_boundary_[3];
  AdaptiveBit is_near_, near_side_;
  NumberModel near_distance_;

  AdaptiveBit length_[3][40], top_bit_[40], sign_[3][3];
  std::uint32_t parallelogram_share_;  // in quarters, 0 ... 7
  std::uint64_t last_spread_;
  AdaptiveBit crease_[4];
  NumberModel correction_;
  AdaptiveBit correction_sign_;
};

template <class Visit>
void BaseMeshModel::visit_trained_states(Visit&& visit) {
  visit(&is_new_[0][0], kDegreeClasses * kDegreeClasses, 1, 1);
  visit(&is_new_by_u_[0], kDegreeClasses, 1, 1);
  visit(&is_new_by_v_[0], kDegreeClasses, 1, 1);
  visit(&is_left_[0], kDegreeClasses, 1, 1);
  visit(&is_right_[0], kDegreeClasses, 1, 1);
  visit(&is_boundary_[0], 3, 1, 1);
  visit(&is_near_, 1, 1, 1);
  visit(&near_side_, 1, 1, 1);
  visit(&length_[0][0], 120, 1, 1);
  visit(&top_bit_[0], 40, 1, 1);
  visit(&sign_[0][0], 9, 1, 1);
}

}  // namespace nmc

#include "libnmc/common/base_mesh_coder_inl.h"

#endif  // NMC_COMMON_BASE_MESH_CODER_H_

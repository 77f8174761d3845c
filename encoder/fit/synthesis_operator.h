// SPDX-License-Identifier: Apache-2.0
// Synthesis of a normal mesh as a linear map: from changes of the unknowns to displacements of the finest
// vertices, and its transpose.
//
// With the normals frozen, a normal mesh is linear in its coefficients: each level adds to the butterfly
// prediction P v of its odd vertices the coefficient times a fixed direction,
//     v_odd = P v + n c + along a + across b.
// Neither the matrix J of all levels nor its transpose is ever formed: a forward pass is one subdivision, an
// adjoint pass is one subdivision run backwards.
//
// The operator also applies J^-1 and J^-T of its square part (all normal coefficients and the base positions
// seen as unknowns of the *finest vertices'* normal displacements). In these coordinates the least-squares
// problem is a mass matrix, well conditioned on every mesh, which makes them the right preconditioner: the
// hierarchical basis by itself has a condition number that grows with 4^levels.
//
// Based on: Zorin, Schroeder, Sweldens 1996 (stencils); Yserentant, On the multi-level splitting of finite
// element spaces, Numer. Math. 49, 1986 (hierarchical bases and their conditioning).
#ifndef NMC_ENCODER_FIT_SYNTHESIS_OPERATOR_H_
#define NMC_ENCODER_FIT_SYNTHESIS_OPERATOR_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "encoder/core/subdivision_hierarchy.h"
#include "libnmc/common/vec3.h"

namespace nmc {

/// Where each unknown of the fit lives in one flat vector: first the base positions (3 i + k), then the
/// normal coefficients level by level, then pairs (along, across) of the edges that have a tangential part.
struct UnknownLayout {
  UnknownLayout() = default;
  /// `tangential_edges[l]`: increasing edges of level l. Levels from `coded_level_count` on have no unknowns.
  UnknownLayout(const SubdivisionHierarchy& hierarchy, int coded_level_count,
                std::vector<std::vector<std::uint32_t>> tangential_edges);

  std::size_t normal(int level, std::size_t edge) const {
    return normal_begin[static_cast<std::size_t>(level)] + edge;
  }

  int coded_level_count = 0;
  std::size_t base_vertex_count = 0;
  std::vector<std::size_t> normal_begin;      // per coded level, and the end
  std::vector<std::size_t> tangential_begin;  // per coded level, and the end
  std::vector<std::vector<std::uint32_t>> tangential_edges;
  std::size_t count = 0;
};

/// One entry of a sparse row.
struct StencilEntry {
  std::uint32_t index;
  float weight;
};

/// Prediction stencils of one level as sparse rows (one per edge), and their transpose (one per vertex).
struct LevelStencils {
  LevelStencils(const LevelTopology& topology, const RingWeights& ring_weights, Tension tension);

  std::vector<std::uint32_t> row_begin, column_begin;
  std::vector<StencilEntry> rows, columns;
};

/// Not thread-safe for writing; every pass is parallel inside. Memory about 130 bytes per finest vertex.
class SynthesisOperator {
 public:
  /// `hierarchy` must outlive the operator. The finest vertices are those of its last level. `tension` has
  /// one share per level; empty: all 1.
  SynthesisOperator(const SubdivisionHierarchy& hierarchy, UnknownLayout layout,
                    std::vector<double> tension = {});

  const SubdivisionHierarchy& hierarchy() const { return hierarchy_; }
  const UnknownLayout& layout() const { return layout_; }
  const std::vector<double>& tension() const { return tension_; }
  const LevelStencils& stencils(int level) const { return stencils_[static_cast<std::size_t>(level)]; }
  std::size_t finest_vertex_count() const { return finest_vertex_count_; }

  /// Positions of the finest vertices from the *values* of all unknowns, by the decoder's rules; freezes the
  /// directions of the linear map at them.
  void synthesize(const std::vector<double>& values, std::vector<Vec3>& positions);
  /// The same without touching the frozen directions.
  void positions_of(const std::vector<double>& values, std::vector<Vec3>& positions) const;

  /// displacements = J change.
  void forward(const std::vector<double>& change, std::vector<Vec3>& displacements) const;
  /// dual = J^T force. `force` is used up.
  void adjoint(std::vector<Vec3>& force, std::vector<double>& dual) const;

  /// J^-1 of the square part: `scalars` holds 3 components of each base vertex, then the normal component of
  /// the displacement of each odd vertex of the coded levels, in the order of the unknowns. Tangential
  /// unknowns stay 0.
  void analyze(const std::vector<double>& scalars, std::vector<double>& change) const;
  /// The transpose of analyze().
  void analyze_transposed(const std::vector<double>& dual, std::vector<double>& scalar_dual) const;

  /// Frozen direction of the normal coefficient of `edge`.
  const Vec3& normal(int level, std::size_t edge) const {
    return normals_[layout_.normal(level, edge) - layout_.normal_begin[0]];
  }
  /// Frozen directions (along, across) of the i-th tangential edge of `level`.
  const Vec3* tangential_frame(int level, std::size_t i) const {
    const auto l = static_cast<std::size_t>(level);
    return frames_.data() + (layout_.tangential_begin[l] - layout_.tangential_begin[0] + 2 * i);
  }

 private:
  template <bool kFreeze, class Self>
  static void decode(Self& self, const std::vector<double>& values, std::vector<Vec3>& positions);

  const SubdivisionHierarchy& hierarchy_;
  UnknownLayout layout_;
  std::vector<double> tension_;
  std::vector<LevelStencils> stencils_;
  std::size_t finest_vertex_count_ = 0;
  std::vector<Vec3> normals_;  // per normal unknown
  std::vector<Vec3> frames_;   // per tangential unknown: its direction
};

}  // namespace nmc

#endif  // NMC_ENCODER_FIT_SYNTHESIS_OPERATOR_H_

// SPDX-License-Identifier: Apache-2.0
// Interpolating normal meshes: every new vertex lies where the normal line through its predicted position
// pierces the input, so that one scalar describes it.
//
// Based on: Friedel, "Approximation of Surfaces by Normal Meshes" (thesis), section 2.3 and Figure 2.5;
// Guskov, Vidimce, Sweldens, Schroeder, "Normal Meshes" (2000); Khodakovsky, Litke, Schroeder, "Globally
// smooth parameterizations" (2003), hinge maps.
#ifndef NMC_ENCODER_NORMAL_MESH_INTERPOLATING_NORMAL_MESH_H_
#define NMC_ENCODER_NORMAL_MESH_INTERPOLATING_NORMAL_MESH_H_

#include <cstdint>
#include <span>
#include <vector>

#include "encoder/normal_mesh/normal_mesh.h"
#include "encoder/normal_mesh/parameter_prediction.h"
#include "encoder/normal_mesh/parameterized_surface.h"
#include "encoder/spatial/surface_index.h"

namespace nmc {

/// How far from its predicted parameter a piercing point may lie.
enum class ApertureRule {
  /// The thesis's: within `aperture` times half the edge's length in the domain. 0.43 separates the circles
  /// of
  /// neighbouring edges of an equilateral triangle.
  kParametric,
  /// Judged on the surface: the point divides the way along the surface between the edge's ends in a ratio
  /// within
  /// +-aperture/2 of one half, less where that way bends (bulge_tolerance). In the domain only 0.9 of half
  /// the edge's
  /// length is asked; the flip test guards the rest. So flat regions follow the normals however the map is
  /// distorted
  /// there, and extremities keep their share of vertices (thesis section 2.4.2 asks for this).
  kAdaptive,
};

struct InterpolatingOptions {
  int level_count = 4;
  ApertureRule aperture_rule = ApertureRule::kAdaptive;
  double coarse_aperture = 0.6;  // at level 0
  double fine_aperture = 0.8;    // from level 4 on, linear between
  /// kAdaptive: a way that is longer than its chords by this share halves the aperture, by twice as much
  /// divides it by three, and so on, down to least_aperture.
  double bulge_tolerance = 0.03;
  double least_aperture = 0.05;
  ParameterPrediction parameter_prediction = ParameterPrediction::kButterfly;
  /// Share of the butterfly's correction; 0 is midpoint prediction of positions.
  double tension = 1;
  /// Cosine that the surface normal at a piercing point must have with the normal line, at least.
  double least_normal_agreement = 0.2;
  /// Length of the normal line to each side, in edge lengths.
  double reach_in_edges = 2.5;
  /// Smallest domain area of a child face, relative to its parent.
  double least_child_area = 0.02;
};

struct LevelStatistics {
  std::uint32_t vertex_count = 0;       // odd vertices of the level
  std::uint32_t non_normal_count = 0;   // of them
  std::uint32_t missed_count = 0;       // non-normal: the line meets nothing acceptable
  std::uint32_t flip_count = 0;         // non-normal: would turn a face over in the domain
  std::uint32_t folded_face_count = 0;  // faces that were folded in the domain before the level began
};

/// The odd vertices of one level.
struct LevelInsertion {
  std::vector<Vec3> positions;               // per edge: the point of the input
  std::vector<SurfaceParameter> parameters;  // per edge: its parameter
  std::vector<OddVertexDetail> details;      // per edge: from the prediction to the point
  std::vector<std::uint8_t> non_normal;      // per edge
  LevelStatistics statistics;
};

/// Inserts the odd vertices of `level` into a mesh whose vertices have the given positions and parameters;
/// the positions may be those of a decoder. `index` must hold map.surface(). Deterministic for any number of
/// threads; parallel over edges; about one ray per edge.
LevelInsertion insert_level(const ParameterizedSurface& map, const SurfaceIndex& index,
                            const SubdivisionHierarchy& hierarchy, int level, std::span<const Vec3> positions,
                            std::span<const SurfaceParameter> parameters,
                            const InterpolatingOptions& options);

struct InterpolatingResult {
  NormalMesh mesh;
  std::vector<Vec3> positions;               // of the finest level: reconstruct(mesh, level_count)
  std::vector<SurfaceParameter> parameters;  // of the same vertices
  std::vector<LevelStatistics> levels;

  /// Of all odd vertices.
  double non_normal_share() const;
};

/// Figure 2.5: levels 0 ... options.level_count.
InterpolatingResult interpolate(const ParameterizedSurface& map, const SurfaceIndex& index,
                                const ParameterizedBase& base, const InterpolatingOptions& options);

}  // namespace nmc

#endif  // NMC_ENCODER_NORMAL_MESH_INTERPOLATING_NORMAL_MESH_H_

// SPDX-License-Identifier: Apache-2.0
// A map of the present state of a CornerTable into a base domain, and the moves that keep it a bijection.
//
// Every live triangle stores how its corners' charts lie relative to its own chart, so unfolding a star costs
// a few integer rotations, never searches, and cannot go round a cone the wrong way.
#ifndef NMC_ENCODER_DOMAIN_SURFACE_MAP_H_
#define NMC_ENCODER_DOMAIN_SURFACE_MAP_H_

#include <array>
#include <cstdint>
#include <vector>

#include "encoder/domain/base_domain.h"
#include "encoder/domain/maps_collapse.h"
#include "encoder/domain/parameterization.h"
#include "encoder/domain/star_energy.h"

namespace nmc {

class SurfaceMap {
 public:
  using Corner = CornerTable::Corner;

  /// The map of the base that the first `step_count` steps lead to onto itself: undoes the steps beyond.
  SurfaceMap(const CollapseHistory& history, std::size_t step_count);

  const CornerTable& table() const { return table_; }
  const BaseDomain& domain() const { return domain_; }
  const CollapseHistory& history() const { return history_; }
  const DomainPoint& point(std::uint32_t v) const { return points_[v]; }
  bool is_cone(std::uint32_t v) const { return cone_index_[v] != kNoVertex; }
  const std::vector<std::uint32_t>& base_vertices() const { return base_vertices_; }
  const Vec3& position(std::uint32_t v) const { return history_.surface->positions[v]; }
  std::size_t steps_left() const { return steps_left_; }
  std::size_t live_vertex_count() const { return live_vertex_count_; }

  /// The triangles around a vertex, real ones only, unfolded into one chart.
  struct StarTriangle {
    Corner corner;    // at the vertex
    ChartPoint q, r;  // vertices next(corner), previous(corner)
  };
  /// The star of a vertex that is not a cone in the chart of its own face. Ghost faces are left out; the
  /// triangles of a boundary vertex come in counter-clockwise order.
  void star(std::uint32_t v, std::vector<StarTriangle>& triangles) const;

  /// True when every triangle of `triangles` is counter-clockwise with its vertex at `z` (a grid point).
  static bool is_positive(const std::vector<StarTriangle>& triangles, const ChartPoint& z);

  /// Moves v, not a cone, to `z` in the chart of its present face; the segment must lie within its star's
  /// kernel. A chain vertex must stay on its base edge. Threads may move vertices that share no triangle.
  void move(std::uint32_t v, const ChartPoint& z, const std::vector<StarTriangle>& triangles);

  /// The lattice direction of the base edge on which a chain vertex lies.
  ChartPoint chain_direction(std::uint32_t v) const;

  /// Undoes the next step and places the vertex that appears. Returns that vertex, or kNoVertex after an
  /// unflip. `scale` gives, per base face, domain area per surface area, for the target areas.
  std::uint32_t undo_step(const EnergyWeights& weights, const std::vector<double>& scale);

  /// How much domain area a vertex's neighbourhood deserves, relative to its surface area; 1 at first.
  /// Vertices that appear get the mean of their neighbours.
  double density(std::uint32_t v) const { return density_[v]; }
  void set_density(std::vector<double> density) { density_ = std::move(density); }

  /// Makes every triangle's chart that of its first corner's face, so that coordinates stay small.
  void recenter_charts();

  /// How often a vertex found no place in the kernel of its link.
  std::size_t failed_insertions() const { return failed_insertions_; }

  /// The finished map; all steps must be undone.
  Parameterization release();

 private:
  struct LinkTriangle {
    Corner corner;  // at the vertex that appears
    ChartMap to_work;
    ChartPoint q, r;
    bool is_new;  // beside the edge v - u
  };
  void build_domain();
  void limit_slides();
  bool leaves_tip(std::uint32_t cone, std::uint32_t v) const;
  /// What place_vertex may change, to be put back.
  struct Saved {
    std::array<std::uint32_t, 2> vertices{};
    std::array<DomainPoint, 2> points;
    std::array<std::uint32_t, 2> cones{};
    std::vector<std::uint32_t> faces;
    std::vector<TriangleChart> charts;
  };
  void place_vertex(std::uint32_t v, Corner step, const EnergyWeights& weights,
                    const std::vector<double>& scale);
  bool try_place(Corner step);
  bool unfold_link(Corner step);
  bool winds_once(const ChartPoint& z, bool half) const;
  void pass_cone(std::uint32_t from, std::uint32_t to);
  Saved save(std::uint32_t u, std::uint32_t v) const;
  void restore(const Saved& saved);
  double energy(const std::vector<std::uint32_t>& faces, const EnergyWeights& weights,
                const std::vector<double>& scale) const;
  ChartPoint interior_start(std::uint32_t v) const;
  ChartPoint chain_start(std::uint32_t v, std::uint32_t u) const;
  void descend(std::uint32_t v, const EnergyWeights& weights, const std::vector<double>& scale,
               int iterations);

  const CollapseHistory& history_;
  CornerTable table_;
  BaseDomain domain_;
  std::vector<DomainPoint> points_;
  std::vector<TriangleChart> charts_;
  std::vector<double> density_;
  std::vector<std::uint32_t> cone_index_;  // base vertex at which a surface vertex sits, or kNoVertex
  std::vector<std::uint32_t> base_vertices_;
  std::vector<std::uint32_t> homes_;  // surface vertex at which each base vertex began
  std::vector<double> slide_radius_;  // how far it may go from there; negative: any distance
  std::size_t steps_left_ = 0, live_vertex_count_ = 0, failed_insertions_ = 0;

  // Scratch of undo_step.
  std::vector<LinkTriangle> link_;
  std::vector<StarTriangle> star_;
  std::uint32_t anchor_face_ = kNoFace;
  ChartPoint anchor_;
};

}  // namespace nmc

#endif  // NMC_ENCODER_DOMAIN_SURFACE_MAP_H_

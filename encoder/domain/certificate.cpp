// SPDX-License-Identifier: Apache-2.0
#include "encoder/domain/certificate.h"

#include <cmath>
#include <numbers>

#include "encoder/domain/corner_table.h"
#include "encoder/domain/exact_orientation.h"

namespace nmc {
namespace {

using Corner = CornerTable::Corner;

class Checker {
 public:
  explicit Checker(const Parameterization& p)
      : p_(p),
        table_(p.surface->vertex_count(), p.surface->triangles),
        cone_(p.surface->vertex_count(), kNoVertex) {
    for (std::uint32_t i = 0; i < p.base_vertex_ids.size(); ++i) cone_[p.base_vertex_ids[i]] = i;
  }

  Certificate run() {
    check_triangles();
    check_edges();
    check_vertices();
    return result_;
  }

 private:
  void check_triangles() {
    double sum = 0;
    for (std::uint32_t f = 0; f < p_.surface->triangle_count(); ++f) {
      const auto [face, corners] = p_.unfold(f);
      const int sign = orientation(corners[0], corners[1], corners[2]);
      sum += face_ratio(corners[0], corners[1], corners[2]);
      result_.flipped += sign < 0;
      result_.degenerate += sign == 0;
      if (sign <= 0) result_.folded_triangles.push_back(f);
    }
    result_.area_ratio = sum / static_cast<double>(p_.domain.face_count());
  }

  const ChartMap& map_at(Corner c) const { return p_.triangle_charts[CornerTable::face_of(c)].maps[c % 3]; }
  ChartPoint at(Corner c) const { return map_at(c)(p_.vertex_points[table_.vertex(c)].at); }
  bool is_cone(Corner c) const { return cone_[table_.vertex(c)] != kNoVertex; }

  /// Both triangles at an edge must differ by one isometry that maps either end point to itself.
  void check_edges() {
    for (Corner c = 0; c < 3 * table_.real_face_count(); ++c) {
      const Corner d = table_.opposite(c);
      if (d < c || table_.is_ghost_face(CornerTable::face_of(d))) continue;
      const Corner a1 = CornerTable::next(c), b1 = CornerTable::previous(c);
      const Corner b2 = CornerTable::next(d), a2 = CornerTable::previous(d);
      bool same = true;
      if (is_cone(a1) && is_cone(b1)) {
        same = squared_length(at(b1) - at(a1)) == squared_length(at(b2) - at(a2));
      } else {
        const bool by_a = !is_cone(a1);
        const ChartMap across =
            by_a ? compose(map_at(a1), inverse(map_at(a2))) : compose(map_at(b1), inverse(map_at(b2)));
        same = across(at(a2)) == at(a1) && across(at(b2)) == at(b1);
      }
      result_.inconsistent += !same;
    }
  }

  void check_vertices() {
    for (std::uint32_t v = 0; v < table_.real_vertex_count(); ++v) {
      const Corner first = table_.corner_at(v);
      if (first == CornerTable::kNone) continue;
      double turn = 0;
      bool boundary = false;
      Corner c = first;
      do {
        if (table_.is_ghost_face(CornerTable::face_of(c))) {
          boundary = true;
        } else {
          const auto [qx, qy] = to_cartesian(at(CornerTable::next(c)) - at(c));
          const auto [rx, ry] = to_cartesian(at(CornerTable::previous(c)) - at(c));
          turn += std::atan2(qx * ry - qy * rx, qx * rx + qy * ry);
        }
        c = table_.rotate(c);
      } while (c != first);
      double sixths = boundary ? 3 : 6;
      if (cone_[v] != kNoVertex) {
        sixths = static_cast<double>(p_.domain.faces_around(cone_[v]).size());
        result_.uncovered += p_.domain.cone_at(p_.vertex_points[v]) != cone_[v];
      }
      result_.wound += std::abs(turn - sixths * std::numbers::pi / 3) > 1e-3;
      if (boundary && !on_boundary_edge(p_.vertex_points[v])) ++result_.off_boundary;
    }
  }

  bool on_boundary_edge(const DomainPoint& p) const {
    const std::uint32_t cone = p_.domain.cone_at(p);
    if (cone != kNoVertex) return p_.domain.is_boundary_vertex(cone);
    const auto b = p.barycentric();
    for (int k = 0; k < 3; ++k)
      if (b[k] == 0 && p_.domain.edge_tag(p.face, k) == EdgeTag::kBoundary) return true;
    return false;
  }

  const Parameterization& p_;
  CornerTable table_;
  std::vector<std::uint32_t> cone_;
  Certificate result_;
};

}  // namespace

Certificate certify(const Parameterization& parameterization) { return Checker(parameterization).run(); }

}  // namespace nmc

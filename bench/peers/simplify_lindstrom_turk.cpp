// SPDX-License-Identifier: Apache-2.0
// Compiled only with NMC_BENCH_GPL: CGAL's simplification package is under the GPL.
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Count_stop_predicate.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/LindstromTurk_cost.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/LindstromTurk_placement.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>

#include "bench/peers/peer.h"

namespace nmc::bench {
namespace {

using Kernel = CGAL::Simple_cartesian<double>;
using SurfaceMesh = CGAL::Surface_mesh<Kernel::Point_3>;
namespace simplification = CGAL::Surface_mesh_simplification;
namespace polygons = CGAL::Polygon_mesh_processing;

}  // namespace

struct LindstromTurkSimplifier::State {
  SurfaceMesh mesh;
};

LindstromTurkSimplifier::LindstromTurkSimplifier(const TriangleMesh& mesh)
    : state_(std::make_unique<State>()) {
  std::vector<Kernel::Point_3> points;
  for (const Vec3& p : mesh.positions) points.emplace_back(p.x, p.y, p.z);
  std::vector<std::vector<std::size_t>> faces;
  for (const Triangle& t : mesh.triangles) faces.push_back({t[0], t[1], t[2]});
  // Cuts the soup apart where it is not manifold, so that any input becomes a half-edge mesh.
  polygons::orient_polygon_soup(points, faces);
  polygons::polygon_soup_to_polygon_mesh(points, faces, state_->mesh);
}

LindstromTurkSimplifier::~LindstromTurkSimplifier() = default;

TriangleMesh LindstromTurkSimplifier::simplify(std::size_t triangle_count) {
  SurfaceMesh& mesh = state_->mesh;
  if (mesh.number_of_faces() > triangle_count) {
    // The stop predicate counts edges: a collapse inside a surface removes three edges and two triangles.
    const std::size_t surplus = mesh.number_of_faces() - triangle_count;
    const std::size_t edges = mesh.number_of_edges();
    const std::size_t edge_target = edges - std::min(edges, surplus * 3 / 2);
    simplification::Count_stop_predicate<SurfaceMesh> stop(edge_target);
    simplification::edge_collapse(
        mesh, stop,
        CGAL::parameters::get_cost(simplification::LindstromTurk_cost<SurfaceMesh>())
            .get_placement(simplification::LindstromTurk_placement<SurfaceMesh>()));
    mesh.collect_garbage();
  }
  TriangleMesh simplified;
  for (const auto vertex : mesh.vertices()) {
    const auto& p = mesh.point(vertex);
    simplified.positions.push_back({p.x(), p.y(), p.z()});
  }
  for (const auto face : mesh.faces()) {
    Triangle triangle{};
    std::size_t i = 0;
    for (const auto vertex : CGAL::vertices_around_face(mesh.halfedge(face), mesh)) {
      triangle[i++] = static_cast<std::uint32_t>(vertex);
    }
    simplified.triangles.push_back(triangle);
  }
  return weld_equal_positions(simplified);
}

}  // namespace nmc::bench

// SPDX-License-Identifier: Apache-2.0
// Based on: OpenMesh's decimater with the quadrics of Garland and Heckbert, "Surface simplification using
// quadric error metrics", 1997, and its check against flipped normals.
#include <OpenMesh/Core/Mesh/Traits.hh>
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Tools/Decimater/DecimaterT.hh>
#include <OpenMesh/Tools/Decimater/ModNormalFlippingT.hh>
#include <OpenMesh/Tools/Decimater/ModQuadricT.hh>
#include <memory>

#include "bench/peers/peer.h"

namespace nmc::bench {
namespace {

using HalfedgeMesh = OpenMesh::TriMesh_ArrayKernelT<OpenMesh::DefaultTraitsDouble>;

using Decimater = OpenMesh::Decimater::DecimaterT<HalfedgeMesh>;

void build(const TriangleMesh& source, HalfedgeMesh& mesh) {
  std::vector<HalfedgeMesh::VertexHandle> vertices;
  for (const Vec3& p : source.positions) vertices.push_back(mesh.add_vertex({p.x, p.y, p.z}));
  for (const Triangle& t : source.triangles) {
    // A triangle at a complex edge is refused by the half-edge structure; it gets vertices of its own.
    if (mesh.add_face(vertices[t[0]], vertices[t[1]], vertices[t[2]]).is_valid()) continue;
    HalfedgeMesh::VertexHandle own[3];
    for (std::size_t i = 0; i < 3; ++i) own[i] = mesh.add_vertex(mesh.point(vertices[t[i]]));
    mesh.add_face(own[0], own[1], own[2]);
  }
  mesh.request_vertex_status();
  mesh.request_edge_status();
  mesh.request_face_status();
  mesh.request_face_normals();
  mesh.update_face_normals();
}

}  // namespace

struct OpenMeshSimplifier::State {
  explicit State(const TriangleMesh& source) {
    build(source, mesh);
    decimater = std::make_unique<Decimater>(mesh);
    OpenMesh::Decimater::ModQuadricT<HalfedgeMesh>::Handle quadric;
    OpenMesh::Decimater::ModNormalFlippingT<HalfedgeMesh>::Handle flipping;
    decimater->add(quadric);
    decimater->add(flipping);
    decimater->module(quadric).unset_max_err();
    decimater->initialize();
  }
  HalfedgeMesh mesh;
  std::unique_ptr<Decimater> decimater;  // keeps the cumulated quadrics from one call to the next
};

OpenMeshSimplifier::OpenMeshSimplifier(const TriangleMesh& mesh) : state_(std::make_unique<State>(mesh)) {}
OpenMeshSimplifier::~OpenMeshSimplifier() = default;

TriangleMesh OpenMeshSimplifier::simplify(std::size_t triangle_count) {
  HalfedgeMesh& mesh = state_->mesh;
  std::size_t alive = 0;
  for ([[maybe_unused]] const auto face : mesh.faces()) ++alive;
  if (alive > triangle_count) {
    // The decimater counts from n_faces(), which includes faces that earlier calls have deleted.
    state_->decimater->decimate_to_faces(0, mesh.n_faces() - (alive - triangle_count));
  }
  TriangleMesh simplified;
  for (std::size_t v = 0; v < mesh.n_vertices(); ++v) {
    const auto& p = mesh.point(HalfedgeMesh::VertexHandle(static_cast<int>(v)));
    simplified.positions.push_back({p[0], p[1], p[2]});
  }
  for (const auto face : mesh.faces()) {
    Triangle triangle{};
    std::size_t i = 0;
    for (const auto vertex : mesh.fv_range(face)) triangle[i++] = static_cast<std::uint32_t>(vertex.idx());
    simplified.triangles.push_back(triangle);
  }
  return weld_equal_positions(simplified);
}

}  // namespace nmc::bench

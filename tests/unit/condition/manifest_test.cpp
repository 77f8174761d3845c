// SPDX-License-Identifier: Apache-2.0
// analyze_topology() against the figures of corpus/manifest.json, which an independent program found.
#include <algorithm>
#include <catch2/catch.hpp>
#include <fstream>
#include <nlohmann/json.hpp>

#include "encoder/condition/topology.h"
#include "encoder/condition/weld.h"
#include "tests/unit/condition/oriented_manifold.h"

using namespace nmc;

TEST_CASE("analyze_topology: agrees with the manifest on every mesh of the corpus", "[topology][corpus]") {
  std::ifstream file(std::string(NMC_SOURCE_DIR) + "/corpus/manifest.json");
  const nlohmann::json manifest = nlohmann::json::parse(file);
  REQUIRE(manifest["meshes"].size() == 41);
  for (const nlohmann::json& entry : manifest["meshes"]) {
    TriangleMesh mesh;
    if (!test::read_corpus_mesh(entry["file"], mesh)) continue;
    const std::vector<std::uint8_t> all(mesh.vertex_count(), 1);
    const std::vector<std::uint32_t> welded = conditioning::equal_vertices(mesh.positions, all);
    for (Triangle& t : mesh.triangles)
      for (std::uint32_t& v : t) v = welded[v];
    std::vector<std::uint8_t> is_used(mesh.vertex_count(), 0);  // by degenerate triangles too
    for (const Triangle& t : mesh.triangles)
      for (const std::uint32_t v : t) is_used[v] = 1;
    std::erase_if(mesh.triangles,
                  [](const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; });
    const Topology topology = analyze_topology(mesh);
    nlohmann::json found = {{"vertices", std::count(is_used.begin(), is_used.end(), 1)},
                            {"components", topology.components.size()},
                            {"boundaryLoops", topology.boundary_loops.size()},
                            {"genusTotal", topology.total_genus()},
                            {"nonManifoldEdges", topology.non_manifold_edge_count},
                            {"nonManifoldVertices", topology.non_manifold_vertex_count},
                            {"misorientedEdges", topology.misoriented_edge_count}};
    std::size_t closed = 0;
    for (const ComponentTopology& component : topology.components)
      closed += component.boundary_loop_count == 0;
    found["closedComponents"] = closed;
    CAPTURE(entry["file"]);
    for (const auto& [key, value] : found.items()) {
      if (entry["topology"][key].is_null()) continue;  // not defined there
      CAPTURE(key);
      CHECK(value == entry["topology"][key]);
    }
  }
}

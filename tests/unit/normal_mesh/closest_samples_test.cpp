// SPDX-License-Identifier: Apache-2.0
#include "encoder/normal_mesh/closest_samples.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "encoder/core/subdivision_hierarchy.h"

TEST_CASE("closest samples cover their faces evenly and lie on the input") {
  // A flat square a little above a larger one.
  const std::vector<nmc::Vec3> positions = {{0, 0, 0.1}, {1, 0, 0.1}, {1, 1, 0.1}, {0, 1, 0.1}};
  const std::vector<nmc::Triangle> faces = {{0, 1, 2}, {0, 2, 3}};
  nmc::TriangleMesh input;
  input.positions = {{-1, -1, 0}, {2, -1, 0}, {2, 2, 0}, {-1, 2, 0}};
  input.triangles = faces;
  const nmc::SurfaceIndex index(input);
  const nmc::SubdivisionHierarchy hierarchy(faces, 4, 0);
  for (const std::size_t count : {1u, 50u, 1000u}) {
    const auto samples = nmc::closest_samples(index, hierarchy.level(0), positions, count);
    CHECK(samples.size() >= count);
    double weight = 0;
    nmc::Vec3 mean;
    for (const nmc::SurfaceSample& s : samples) {
      for (const float b : s.barycentric) CHECK(b > 0);
      CHECK(std::abs(s.barycentric[0] + s.barycentric[1] + s.barycentric[2] - 1) < 1e-6);
      CHECK(std::abs(s.target.z) < 1e-12);
      CHECK(s.normal.z == Approx(1));
      weight += static_cast<double>(s.weight);
      mean += static_cast<double>(s.weight) * s.target;
    }
    CHECK(weight == Approx(1).epsilon(1e-5));
    CHECK(mean.x == Approx(0.5).epsilon(1e-4));
    CHECK(mean.y == Approx(0.5).epsilon(1e-4));
  }
}

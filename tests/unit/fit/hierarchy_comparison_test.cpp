// SPDX-License-Identifier: Apache-2.0
#include "encoder/fit/hierarchy_comparison.h"

#include <catch2/catch.hpp>

#include "tests/unit/fit/bumpy_sphere.h"

namespace nmc {

TEST_CASE("Interpolating, variational, fitted and unconstrained hierarchies come in the expected order") {
  const BumpySphere surface;
  NormalMesh mesh = interpolating_mesh(surface, 5);
  const std::vector<SurfaceSample> samples = radial_samples(surface, mesh);
  const HierarchyComparison result = compare_hierarchies({}, nullptr, samples, mesh);
  QuadraticEnergy energy(mesh.hierarchy.level(5));
  energy.assemble(samples, result.interpolating, {});
  const auto rms = [&](const std::vector<Vec3>& x) { return energy.root_mean_square(energy.value(x)); };
  INFO("INM " << rms(result.interpolating) << ", VNM " << rms(result.variational) << ", fit "
              << rms(result.fit) << ", VVM " << rms(result.vectors));
  CHECK(rms(result.variational) < rms(result.interpolating));
  CHECK(rms(result.fit) < rms(result.variational) * 1.02);
  CHECK(rms(result.vectors) <= rms(result.fit) * 1.0001);
  CHECK(rms(result.fit) <= rms(result.vectors) * 1.06);
}

}  // namespace nmc

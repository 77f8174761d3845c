// SPDX-License-Identifier: Apache-2.0
#include "bench/decode/equal_error.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "encoder/core/error.h"
#include "encoder/measure/compare_meshes.h"

namespace nmc::bench {

namespace {

constexpr double kTriangleFactor = 0.88;
constexpr double kGridShare = 0.2;  // of the squared error

double rms_of(const BenchMesh& original, const TriangleMesh& mesh) {
  CompareOptions options;
  options.original_index = &original.index;
  options.colors = false;
  return compare_meshes(original.original, mesh, options).relative_rms();
}

FloatMesh to_floats(const TriangleMesh& mesh) {
  FloatMesh out;
  for (const Vec3& p : mesh.positions)
    for (int k = 0; k < 3; ++k) out.positions.push_back(static_cast<float>(p[k]));
  for (const Triangle& t : mesh.triangles) out.indices.insert(out.indices.end(), t.begin(), t.end());
  return out;
}

}  // namespace

double relative_rms(const BenchMesh& original, const FloatMesh& mesh) {
  TriangleMesh converted;
  for (std::size_t i = 0; i < mesh.positions.size(); i += 3)
    converted.positions.push_back({mesh.positions[i], mesh.positions[i + 1], mesh.positions[i + 2]});
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3)
    converted.triangles.push_back({mesh.indices[i], mesh.indices[i + 1], mesh.indices[i + 2]});
  return rms_of(original, converted);
}

EqualErrorMesh mesh_of_equal_error(const BenchMesh& original, double target_rms) {
  EqualErrorMesh result;
#ifdef NMC_BENCH_GPL
  LindstromTurkSimplifier simplifier(original.welded);
  result.simplifier = "Lindstrom-Turk";
#else
  MeshoptSimplifier simplifier(original.welded);
  result.simplifier = "meshoptimizer";
#endif
  const Vec3 size = original.box.maximum - original.box.minimum;
  const double side = std::max({size.x, size.y, size.z}) / original.box.diagonal();
  // Rounding to a step s has a root mean square of s / sqrt(12) along the normal.
  const double step = target_rms * std::sqrt(12 * kGridShare);
  result.position_bits = std::clamp(static_cast<int>(std::ceil(std::log2(side / step + 1))), 8, 16);
  std::size_t previous = original.welded.triangle_count();
  for (double count = static_cast<double>(previous); count >= 100; count *= kTriangleFactor) {
    const TriangleMesh simplified = simplifier.simplify(static_cast<std::size_t>(count));
    if (simplified.triangles.empty() ||
        (count < static_cast<double>(previous) && simplified.triangle_count() > previous))
      break;
    const double rms = rms_of(original, code_with_draco(simplified, result.position_bits).decoded);
    if (rms > target_rms) break;
    previous = simplified.triangle_count();
    result.mesh = to_floats(simplified);
    result.rms = rms;
  }
  if (result.mesh.indices.empty())
    throw Error(ExitCode::kTargetNotMet, "16 bits per coordinate are not enough");
  return result;
}

}  // namespace nmc::bench

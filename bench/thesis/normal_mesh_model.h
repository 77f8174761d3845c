// SPDX-License-Identifier: Apache-2.0
// Models for the experiments of chapter 3: an input, its parameterization, a base, and the meshes over them.
#ifndef NMC_BENCH_THESIS_NORMAL_MESH_MODEL_H_
#define NMC_BENCH_THESIS_NORMAL_MESH_MODEL_H_

#include <memory>
#include <string>
#include <vector>

#include "encoder/domain/parameterize.h"
#include "encoder/measure/compare_meshes.h"
#include "encoder/normal_mesh/interpolating_normal_mesh.h"
#include "encoder/normal_mesh/variational_normal_mesh.h"
#include "encoder/sphere/sphere_base.h"
#include "encoder/sphere/sphere_parameterization.h"
#include "encoder/sphere/sphere_surface.h"

namespace nmc_bench {

using namespace nmc;

// A parameterized model and its base, ready for any number of normal meshes.
struct Model {
  std::string name, parameterization;
  std::shared_ptr<const TriangleMesh> input;
  std::shared_ptr<const Parameterization> domain;  // keeps the surface's data alive
  std::unique_ptr<ParameterizedSurface> surface;
  ParameterizedBase base;
  int level_count = 0;
};

/// `mesh` on the sphere, with a base of the given kind.
Model on_sphere(const std::string& name, TriangleMesh mesh, const SphereBaseOptions& base, int level_count,
                const SphereEnergyWeights& weights = {});

/// `mesh` on its own base domain.
Model on_domain(const std::string& name, TriangleMesh mesh, int base_size, int level_count);

/// `mesh` on the base mesh it is a subdivision of, the thesis's R^0 ... R^L, with one level less than it has.
/// Throws nmc::Error where its connectivity is no such subdivision.
Model on_own_base(const std::string& name, TriangleMesh mesh);

/// The model's surface at the dyadic points of `level_count` levels: what a remesher that knows no normals
/// would write.
TriangleMesh plain_remesh(const Model& model, int level_count);

/// A unit sphere with a displacement of rising frequency along the equator, fading towards the poles.
TriangleMesh zone_sphere(int subdivisions);

/// The first vertices of `positions` as the mesh of one level.
TriangleMesh mesh_of(const SubdivisionHierarchy& hierarchy, int level, const std::vector<Vec3>& positions);

/// Distances between a model's input, held by `index`, and `mesh`; 100,000 points each way.
CompareResult compared(const Model& model, const SurfaceIndex& index, const TriangleMesh& mesh);

/// kParametric is the thesis's setting: aperture 0.2 on all levels, midpoint prediction of parameters.
InterpolatingOptions thesis_options(int level_count, ApertureRule rule);

/// The variational mesh of Fig. 3.6 over the same prediction and apertures: S^0 = R^0.
VariationalOptions thesis_options(const InterpolatingOptions& interpolating);

/// Level `level` of a normal mesh with one scalar per vertex, chosen for that level by the global fit.
/// `index` holds the model's surface.
TriangleMesh fitted(const Model& model, const SurfaceIndex& index, InterpolatingOptions options, int level);

}  // namespace nmc_bench

#endif  // NMC_BENCH_THESIS_NORMAL_MESH_MODEL_H_

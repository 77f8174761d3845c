// SPDX-License-Identifier: Apache-2.0
// Generated surfaces, each of which is hard for a normal-mesh codec in one known way.
//
// Every function is deterministic and gives an oriented manifold with outward normals unless it says
// otherwise. Sizes are of the order of one unit.
#ifndef NMC_CORPUS_GENERATE_SHAPES_H_
#define NMC_CORPUS_GENERATE_SHAPES_H_

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "encoder/core/triangle_mesh.h"

namespace nmc::corpus {

// ---------------------------------------------------------------------------------------------- round
// (round.cpp)

/// An icosahedron split `level` times and projected to the unit sphere: 20 * 4^level triangles.
TriangleMesh icosphere(int level);

/// A sphere whose radius is 1 + 0.02 sin(k longitude^2), with waves that grow shorter along the equator from
/// 0 to pi and fade towards the poles: the aliasing test of the thesis, Fig. 3.7. `waves` is the number of
/// half waves.
TriangleMesh zone_sphere(int level, int waves = 40);

/// A sphere with independent normal noise of standard deviation `amplitude` at every vertex.
TriangleMesh noisy_sphere(int level, double amplitude = 0.002, std::uint64_t seed = 1);

/// A ball with `spike_count` long thin spikes at Fibonacci directions: extremities that a base mesh must not
/// starve.
TriangleMesh spiky_ball(int level, int spike_count = 60, double spike_length = 0.8);

// ---------------------------------------------------------------------------------------------- swept
// (swept.cpp)

/// A torus with the given numbers of segments; genus 1.
TriangleMesh torus(int around, int across, double tube_radius = 0.3);

/// A capped tube whose length is `aspect` times its diameter; closed, genus 0.
TriangleMesh long_cylinder(double aspect = 1000, int around = 24, int along = 4000);

/// A tube around the (p, q) torus knot; genus 1, knotted.
TriangleMesh torus_knot(int p = 2, int q = 3, int along = 1500, int around = 24, double tube_radius = 0.12);

/// A Moebius strip; one boundary, not orientable.
TriangleMesh moebius_strip(int around, int across);

/// A Klein bottle (the figure-eight immersion, which crosses itself); closed, not orientable.
TriangleMesh klein_bottle(int around, int across);

// ---------------------------------------------------------------------------------------------- sharp
// (sharp.cpp)

/// An octahedron in which every triangle is replaced by its three corner triangles and a pyramid on the
/// middle one, `level` times: 8 * 6^level triangles, detail at every scale, creases everywhere. Does not
/// touch itself.
TriangleMesh koch_surface(int level);

/// A spur gear with a bore: flat faces, sharp edges, genus 1. `segments` subdivides each flank, tip and root.
TriangleMesh gear(int tooth_count = 24, int segments = 6);

/// The surface of a set of unit cells of a grid, where is_solid(x, y, z) says which; outside the grid nothing
/// is. Cells that touch only along an edge or in a corner give a non-manifold mesh.
TriangleMesh voxel_surface(int nx, int ny, int nz, const std::function<bool(int, int, int)>& is_solid,
                           const Vec3& cell = {1, 1, 1});

/// A plate with nx * ny square holes: genus nx * ny.
TriangleMesh perforated_plate(int nx, int ny);

/// A bar with `tine_count` long tines; closed, genus 0.
TriangleMesh comb(int tine_count = 40, int tine_length = 60);

// ---------------------------------------------------------------------------------------------- open
// (open.cpp)

/// A shallow bowl over the unit disk with `hole_count` small holes; one outer boundary. hole_count + 1 loops.
TriangleMesh disk_with_holes(int hole_count = 300);

/// A stack of `sheet_count` closed wavy plates of the given thickness and gap, much thinner than a triangle
/// is wide.
TriangleMesh thin_sheets(int sheet_count = 8, int cells = 60, double thickness = 1e-4, double gap = 1e-4);

/// Disjoint triangles at random places in a cube.
TriangleMesh loose_triangles(std::size_t count, std::uint64_t seed = 2);

/// A height field over the unit square with fractal relief; one boundary. 2 * cells^2 triangles.
TriangleMesh terrain(int cells, std::uint64_t seed = 3);

// ---------------------------------------------------------------------------------------------- gyroid
// (gyroid.cpp)

/// The solid on one side of a gyroid inside a ball, by marching tetrahedra on a grid of `cells`^3: high
/// genus, curved everywhere, creased where the ball cuts it.
TriangleMesh gyroid(int cells = 64, double periods = 2);

// ---------------------------------------------------------------------------------------------- all
// (catalogue.cpp)

struct CatalogueEntry {
  std::string name;
  std::string why;  // what it is hard for
  std::function<TriangleMesh()> make;
};
/// Every shape above at a size that benchmarks use.
const std::vector<CatalogueEntry>& catalogue();

// ---------------------------------------------------------------------------------------------- tools
// (tools.cpp)

/// Puts `part` beside what `mesh` holds.
void append(TriangleMesh& mesh, const TriangleMesh& part);
void translate(TriangleMesh& mesh, const Vec3& offset);
/// Reverses all triangles.
void turn_around(TriangleMesh& mesh);
/// Splits every triangle into four at its edge midpoints.
TriangleMesh split_one_to_four(const TriangleMesh& mesh);
/// Splits triangles, one to four and then longest edges first, until there are at least `triangle_count`, and
/// moves each vertex along its normal by normal noise of deviation `noise` times the diagonal. Gives meshes
/// of any size with the shape of a real scan. O(n log n).
TriangleMesh subdivide(const TriangleMesh& mesh, std::size_t triangle_count, double noise,
                       std::uint64_t seed = 4);

}  // namespace nmc::corpus

#endif  // NMC_CORPUS_GENERATE_SHAPES_H_

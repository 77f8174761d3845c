// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>

#include "corpus/generate/random.h"
#include "corpus/generate/shapes.h"

namespace nmc::corpus {

namespace {
using std::numbers::pi;

TriangleMesh displaced(TriangleMesh sphere, const std::function<double(const Vec3&)>& radius) {
  for (Vec3& p : sphere.positions) p *= radius(p);
  return sphere;
}
}  // namespace

TriangleMesh icosphere(int level) {
  const double g = std::numbers::phi;
  TriangleMesh mesh;
  mesh.positions = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                    {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  mesh.triangles = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                    {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                    {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (Vec3& p : mesh.positions) p = normalized(p);
  for (int i = 0; i < level; ++i) {
    mesh = split_one_to_four(mesh);
    for (Vec3& p : mesh.positions) p = normalized(p);
  }
  return mesh;
}

TriangleMesh zone_sphere(int level, int waves) {
  // The phase k longitude^2 ends on a crest at longitude pi, where both directions meet without a kink.
  const double k = (waves + 0.5) / pi;
  return displaced(icosphere(level), [k](const Vec3& p) {
    const double longitude = std::abs(std::atan2(p.y, p.x));
    const double fade = p.x * p.x + p.y * p.y;  // cosine of the latitude squared
    return 1 + 0.02 * fade * std::sin(k * longitude * longitude);
  });
}

TriangleMesh noisy_sphere(int level, double amplitude, std::uint64_t seed) {
  Random random(seed);
  return displaced(icosphere(level), [&](const Vec3&) { return 1 + amplitude * random.normal(); });
}

TriangleMesh spiky_ball(int level, int spike_count, double spike_length) {
  std::vector<Vec3> spikes;
  for (int i = 0; i < spike_count; ++i) {
    const double z = 1 - (2 * i + 1.0) / spike_count, angle = 2 * pi * i / std::numbers::phi;
    const double r = std::sqrt(1 - z * z);
    spikes.push_back({r * std::cos(angle), r * std::sin(angle), z});
  }
  const double width =
      0.25 / std::sqrt(static_cast<double>(spike_count));  // an eighth of the typical distance
  return displaced(icosphere(level), [&](const Vec3& p) {
    double nearest = 4;
    for (const Vec3& s : spikes) nearest = std::min(nearest, squared_norm(p - s));
    return 1 + spike_length * std::exp(-nearest / (2 * width * width));
  });
}

}  // namespace nmc::corpus

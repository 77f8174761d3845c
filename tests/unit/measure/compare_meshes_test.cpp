// SPDX-License-Identifier: Apache-2.0
#include "encoder/measure/compare_meshes.h"

#include <oneapi/tbb/global_control.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <numbers>

#include "encoder/core/error.h"
#include "encoder/measure/area_samples.h"
#include "tests/unit/spatial/test_meshes.h"

namespace nmc {
namespace {

using test::Random;

// A sphere of the given radius from an octahedron, each triangle split into four `levels` times.
TriangleMesh sphere(int levels, double radius, const Vec3& center = {}) {
  TriangleMesh mesh;
  mesh.positions = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  mesh.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int level = 0; level < levels; ++level) {
    std::vector<Triangle> finer;
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middle_of;
    for (const Triangle& t : mesh.triangles) {
      std::uint32_t middle[3];
      for (std::size_t i = 0; i < 3; ++i) {
        const std::uint32_t from = t[i], to = t[(i + 1) % 3];
        const auto next = static_cast<std::uint32_t>(mesh.positions.size());
        const auto [entry, inserted] = middle_of.try_emplace(std::minmax(from, to), next);
        if (inserted) mesh.positions.push_back(normalized(mesh.positions[from] + mesh.positions[to]));
        middle[i] = entry->second;
      }
      finer.push_back({t[0], middle[0], middle[2]});
      finer.push_back({t[1], middle[1], middle[0]});
      finer.push_back({t[2], middle[2], middle[1]});
      finer.push_back({middle[0], middle[1], middle[2]});
    }
    mesh.triangles = finer;
  }
  for (Vec3& p : mesh.positions) p = center + radius * p;
  return mesh;
}

TriangleMesh noisy(TriangleMesh mesh, double amplitude, std::uint64_t seed) {
  Random random(seed);
  for (Vec3& p : mesh.positions) p += random.point(-amplitude, amplitude);
  return mesh;
}

// Shares no code with the library: every triangle is cut into n^2 equal parts, each part's centroid is
// weighted with its area, and each distance is the smallest over all triangles.
struct BruteForce {
  double rms = 0, mean = 0, maximum = 0;
};
BruteForce brute_force_one_sided(const TriangleMesh& source, const TriangleMesh& target, int n) {
  double area_sum = 0, sum = 0, squares = 0, maximum = 0;
  for (const Triangle& t : source.triangles) {
    const Vec3 a = source.positions[t[0]], b = source.positions[t[1]], c = source.positions[t[2]];
    const double part = norm(cross(b - a, c - a)) / 2 / (n * n);
    const auto visit = [&](double u, double v) {
      const Vec3 point = a + (u / n) * (b - a) + (v / n) * (c - a);
      const double gap = test::brute_force_distance(target, point);
      area_sum += part;
      sum += part * gap;
      squares += part * gap * gap;
      maximum = std::max(maximum, gap);
    };
    for (int i = 0; i < n; ++i) {
      for (int k = 0; i + k < n; ++k) {
        visit(i + 1.0 / 3, k + 1.0 / 3);
        if (i + k < n - 1) visit(i + 2.0 / 3, k + 2.0 / 3);
      }
    }
    for (const Vec3& corner : {a, b, c})
      maximum = std::max(maximum, test::brute_force_distance(target, corner));
  }
  return {std::sqrt(squares / area_sum), sum / area_sum, maximum};
}

TEST_CASE("RMS and mean agree with an independent brute force within half a percent") {
  const struct {
    TriangleMesh original, result;
  } pairs[] = {
      {sphere(2, 1), noisy(sphere(1, 1), 0.05, 3)},
      {test::sheet(6, [](double x, double y) { return std::sin(x) * std::cos(y); }),
       test::sheet(6, [](double x, double y) { return std::sin(x + 0.1) * std::cos(y); })},
      {test::triangle_soup(5, 120, 0.4), test::triangle_soup(6, 90, 0.5)},
      {noisy(sphere(2, 100, {1e6, -2e6, 3e6}), 2, 8), sphere(1, 101, {1e6, -2e6, 3e6})},
  };
  for (const auto& [original, result] : pairs) {
    const CompareResult compared = compare_meshes(original, result);
    const BruteForce forward = brute_force_one_sided(original, result, 16);
    const BruteForce backward = brute_force_one_sided(result, original, 16);
    CAPTURE(original.triangle_count(), result.triangle_count());
    CHECK(compared.original_to_result.rms == Approx(forward.rms).epsilon(0.005));
    CHECK(compared.result_to_original.rms == Approx(backward.rms).epsilon(0.005));
    CHECK(compared.original_to_result.mean == Approx(forward.mean).epsilon(0.005));
    CHECK(compared.result_to_original.mean == Approx(backward.mean).epsilon(0.005));
    CHECK(compared.original_to_result.maximum == Approx(forward.maximum).epsilon(0.02));
    CHECK(compared.result_to_original.maximum == Approx(backward.maximum).epsilon(0.02));
    CHECK(compared.rms == std::max(compared.original_to_result.rms, compared.result_to_original.rms));
  }
}

TEST_CASE("two parallel squares are exactly as far apart as their planes") {
  const TriangleMesh low = test::sheet(10, [](double, double) { return 0.0; });
  const TriangleMesh high = test::sheet(7, [](double, double) { return 0.25; });
  TriangleMesh shrunk = high;
  for (Vec3& p : shrunk.positions) p = {p.x * 10 / 7, p.y * 10 / 7, p.z};
  const CompareResult compared = compare_meshes(low, shrunk);
  CHECK(compared.rms == Approx(0.25).epsilon(1e-12));
  CHECK(compared.mean == Approx(0.25).epsilon(1e-12));
  CHECK(compared.maximum == Approx(0.25).epsilon(1e-12));
  CHECK(compared.diagonal == Approx(std::sqrt(200.0)));
  CHECK(compared.psnr_db() == Approx(20 * std::log10(std::sqrt(200.0) / 0.25)));
  CHECK(compared.normal_mean_degrees == Approx(0).margin(1e-9));
  CHECK_FALSE(compared.original_volume.has_value());
}

TEST_CASE("a surface that covers only half of the other is far away in one direction only") {
  const TriangleMesh whole = test::sheet(8, [](double, double) { return 0.0; });
  TriangleMesh half = whole;
  half.triangles.resize(half.triangles.size() / 2);
  const CompareResult compared = compare_meshes(whole, half);
  CHECK(compared.result_to_original.maximum == 0);
  CHECK(compared.original_to_result.maximum == Approx(4));
  CHECK(compared.original_to_result.maximum_at.y == Approx(8));
  CHECK(compared.original_to_result.rms == Approx(std::sqrt(4.0 * 4 * 4 / 3 / 8)).epsilon(1e-4));
}

TEST_CASE("vertices that no triangle uses do not count") {
  TriangleMesh mesh = sphere(2, 1);
  const TriangleMesh clean = mesh;
  mesh.positions.push_back({100, 100, 100});
  const CompareResult compared = compare_meshes(mesh, clean);
  CHECK(compared.maximum == Approx(0).margin(1e-15));
  CHECK(compared.diagonal == Approx(2 * std::sqrt(3.0)));
}

TEST_CASE("a lone far vertex counts for the maximum but hardly for the RMS") {
  TriangleMesh spiked = test::sheet(40, [](double x, double y) { return x == 20 && y == 20 ? 5.0 : 0.0; });
  const TriangleMesh flat = test::sheet(40, [](double, double) { return 0.0; });
  const CompareResult compared = compare_meshes(flat, spiked);
  CHECK(compared.maximum == 5);
  CHECK(compared.result_to_original.maximum_at.x == 20);
  CHECK(compared.rms < 0.5);
}

TEST_CASE("a turned result is reported as turned and its normals measured as if it were not") {
  const TriangleMesh mesh = sphere(3, 2);
  TriangleMesh turned = noisy(mesh, 0.01, 4);
  const CompareResult straight = compare_meshes(mesh, turned);
  for (Triangle& t : turned.triangles) std::swap(t[0], t[1]);
  const CompareResult reversed = compare_meshes(mesh, turned);
  CHECK_FALSE(straight.orientation_reversed);
  CHECK(reversed.orientation_reversed);
  CHECK(reversed.normal_mean_degrees == Approx(straight.normal_mean_degrees).epsilon(1e-3));
  CHECK(reversed.normal_rms_degrees == Approx(straight.normal_rms_degrees).epsilon(1e-3));
  REQUIRE(reversed.result_volume.has_value());
  CHECK(*reversed.result_volume == Approx(-*straight.result_volume));
}

TEST_CASE("the normal deviation of a tilted square is its angle") {
  const TriangleMesh flat = test::sheet(4, [](double, double) { return 0.0; });
  const TriangleMesh tilted = test::sheet(4, [](double x, double) { return 0.1 * x; });
  const CompareResult compared = compare_meshes(flat, tilted);
  const double degrees = std::atan(0.1) * 180 / std::numbers::pi;
  CHECK(compared.normal_mean_degrees == Approx(degrees));
  CHECK(compared.normal_rms_degrees == Approx(degrees));
}

TEST_CASE("volumes of closed surfaces do not depend on where they lie") {
  const Vec3 far{1e5, 2e5, -3e5};
  const CompareResult near_origin = compare_meshes(sphere(4, 1), sphere(4, 2));
  const CompareResult far_away = compare_meshes(sphere(4, 1, far), sphere(4, 2, far));
  CHECK(*near_origin.original_volume == Approx(4 * std::numbers::pi / 3).epsilon(0.01));
  CHECK(*near_origin.result_volume == Approx(8 * *near_origin.original_volume));
  CHECK(*far_away.original_volume == Approx(*near_origin.original_volume).epsilon(1e-6));
}

TEST_CASE("colour PSNR measures the difference of interpolated colours") {
  TriangleMesh mesh = sphere(3, 1);
  mesh.colors.assign(mesh.vertex_count(), {100, 120, 140});
  TriangleMesh brighter = mesh;
  brighter.colors.assign(mesh.vertex_count(), {110, 120, 140});
  const CompareResult compared = compare_meshes(mesh, brighter);
  REQUIRE(compared.rgb_psnr_db.has_value());
  CHECK(*compared.rgb_psnr_db == Approx(10 * std::log10(255.0 * 255 * 3 / 100)));
  CHECK(*compared.luma_psnr_db == Approx(20 * std::log10(255.0 / 2.126)));
  brighter.colors.clear();
  CHECK_FALSE(compare_meshes(mesh, brighter).rgb_psnr_db.has_value());
}

TEST_CASE("D1 and D2 of two shifted planes follow MPEG's formula") {
  const TriangleMesh low = test::sheet(10, [](double, double) { return 0.0; });
  const TriangleMesh high = test::sheet(10, [](double, double) { return 0.25; });
  CompareOptions options;
  options.mpeg_grid = 64;
  const CompareResult compared = compare_meshes(low, high, options);
  REQUIRE(compared.mpeg.has_value());
  CHECK(compared.mpeg->original_points >= 64 * 64);
  const double expected = 10 * std::log10(3 * 10.0 * 10.0 / (0.25 * 0.25));
  CHECK(compared.mpeg->point_to_point_db == Approx(expected));
  CHECK(compared.mpeg->point_to_plane_db == Approx(expected));
}

TEST_CASE("D2 ignores a shift within the surface and D1 does not") {
  const TriangleMesh flat = test::sheet(10, [](double, double) { return 0.0; });
  TriangleMesh finer = test::sheet(20, [](double, double) { return 0.1; });
  for (Vec3& p : finer.positions) p = {p.x / 2 + 0.07, p.y / 2, p.z};
  CompareOptions options;
  options.mpeg_grid = 64;
  const CompareResult compared = compare_meshes(flat, finer, options);
  CHECK(compared.mpeg->point_to_plane_db == Approx(10 * std::log10(300 / (0.1 * 0.1))));
  CHECK(compared.mpeg->point_to_point_db < compared.mpeg->point_to_plane_db);
}

TEST_CASE("the figures are the same bits for one thread and for many, and with an index of the caller's") {
  const TriangleMesh original = noisy(sphere(5, 1), 0.01, 1), result = noisy(sphere(5, 1), 0.01, 2);
  const CompareResult many = compare_meshes(original, result);
  const SurfaceIndex index(original);
  CompareOptions options;
  options.original_index = &index;
  const oneapi::tbb::global_control one_thread(oneapi::tbb::global_control::max_allowed_parallelism, 1);
  const CompareResult one = compare_meshes(original, result, options);
  CHECK(one.rms == many.rms);
  CHECK(one.mean == many.mean);
  CHECK(one.maximum == many.maximum);
  CHECK(one.normal_rms_degrees == many.normal_rms_degrees);
  CHECK(*one.result_volume == *many.result_volume);
}

TEST_CASE("one direction alone leaves the other at zero and costs no index of the original") {
  CompareOptions options;
  options.result_to_original = false;
  options.sample_count = 1000;
  const CompareResult compared = compare_meshes(sphere(3, 1), sphere(3, 1.1), options);
  CHECK(compared.original_to_result.sample_count == 1000);
  CHECK(compared.result_to_original.sample_count == 0);
  CHECK(compared.rms == compared.original_to_result.rms);
  CHECK(compared.rms > 0.09);
}

TEST_CASE("meshes without triangles are refused and meshes without area measured by their vertices") {
  TriangleMesh line;
  line.positions = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  line.triangles = {{0, 1, 2}};
  TriangleMesh shifted = line;
  for (Vec3& p : shifted.positions) p.y += 0.5;
  CHECK(compare_meshes(line, shifted).rms == Approx(0.5));
  CHECK_THROWS_AS(compare_meshes(TriangleMesh(), line), Error);
  CHECK_THROWS_AS(compare_meshes(line, TriangleMesh()), Error);
}

TEST_CASE("vertices that are not numbers and their triangles are left out") {
  const TriangleMesh clean = sphere(3, 1);
  TriangleMesh damaged = clean;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  damaged.positions.push_back({nan, 0, 0});
  damaged.positions.push_back({0, std::numeric_limits<double>::infinity(), 0});
  const auto first = static_cast<std::uint32_t>(clean.vertex_count());
  damaged.triangles.insert(damaged.triangles.begin(), {Triangle{first, 0, 1}, Triangle{first + 1, 2, 3}});
  for (const CompareResult& compared : {compare_meshes(damaged, clean), compare_meshes(clean, damaged)}) {
    CHECK(compared.maximum == Approx(0).margin(1e-15));
    CHECK(compared.diagonal == Approx(2 * std::sqrt(3.0)));
    CHECK(compared.original_to_result.sample_count == 200'000);
  }
  TriangleMesh lost = damaged;
  lost.triangles.resize(2);
  CHECK_THROWS_AS(compare_meshes(clean, lost), Error);
}

TEST_CASE("area samples are spread by area and stay inside their triangles") {
  const TriangleMesh mesh = noisy(sphere(2, 1), 0.1, 9);
  const AreaSamples samples(mesh.positions, mesh.triangles, 100'000);
  std::vector<double> count(mesh.triangle_count());
  Vec3 moment;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const AreaSample sample = samples[i];
    count[sample.triangle] += 1;
    moment += sample.position;
    REQUIRE(std::min({sample.barycentric[0], sample.barycentric[1], sample.barycentric[2]}) >= 0);
  }
  Vec3 exact_moment;
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
    const Vec3 &a = mesh.positions[mesh.triangles[t][0]], &b = mesh.positions[mesh.triangles[t][1]],
               &c = mesh.positions[mesh.triangles[t][2]];
    const double area = norm(cross(b - a, c - a)) / 2;
    REQUIRE(std::abs(count[t] - 100'000 * area / samples.total_area()) <= 1.0 + 1e-6);
    exact_moment += (area / samples.total_area() / 3) * (a + b + c);
  }
  CHECK(distance(moment / 100'000, exact_moment) < 3e-4);
}

}  // namespace
}  // namespace nmc

// SPDX-License-Identifier: Apache-2.0
// Based on: Wald et al., "Embree: A Kernel Framework for Efficient CPU Ray Tracing", 2014, used as a bounding
// volume hierarchy only: the triangles are user geometry, so every box that a query touches comes back here
// and is decided in double.
//
// Why nothing is missed. The geometry is moved to the centre of its box and scaled by a power of two to about
// [-1, 1]^3, where rounding to float moves a coordinate by at most 2^-24. Every triangle's box is grown by
// kBoxMargin, which covers the rounding of the corners, of a ray's origin and direction (rays are clipped to
// the scene first, so they are at most a few units long) and of the slab test. A point query grows its radius
// by the rounding of the query point instead.
#include "encoder/spatial/surface_index.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>

#include "encoder/core/error.h"
#include "encoder/spatial/triangle_geometry.h"

namespace nmc {
namespace {

constexpr float kBoxMargin = 0x1p-19f;

// A query point farther out than this many scene sizes is compared with every triangle: in float all
// triangles would be equally far.
constexpr double kFarthestFloatPoint = 0x1p20;

// One device for all indices of the process: it owns no geometry and its creation costs milliseconds.
RTCDevice shared_device() {
  static const RTCDevice device = [] {
    RTCDevice created = rtcNewDevice(nullptr);
    if (created == nullptr && rtcGetDeviceError(nullptr) == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
    if (created == nullptr) throw Error(ExitCode::kInternal, "Embree could not be started on this processor");
    return created;
  }();
  return device;
}

Vec3 interpolate(const Vec3& a, const Vec3& b, const Vec3& c, const double weights[3]) {
  return weights[0] * a + weights[1] * b + weights[2] * c;
}

bool on_boundary(const SurfacePoint& hit) {
  return hit.barycentric[0] == 0 || hit.barycentric[1] == 0 || hit.barycentric[2] == 0;
}

struct IndexData {
  std::vector<Vec3> positions;
  std::vector<Triangle> triangles;
  Vec3 center;
  Vec3 half_extent;  // of the used vertices, in units of the input
  double scale = 1;  // power of two; input units to Embree's units
  RTCScene scene = nullptr;

  IndexData() = default;
  IndexData(const IndexData&) = delete;
  IndexData& operator=(const IndexData&) = delete;
  ~IndexData() {
    if (scene != nullptr) rtcReleaseScene(scene);
  }

  Vec3 to_local(const Vec3& p) const { return scale * (p - center); }
  bool is_finite(const Triangle& triangle) const {
    return nmc::is_finite(positions[triangle[0]]) && nmc::is_finite(positions[triangle[1]]) &&
           nmc::is_finite(positions[triangle[2]]);
  }
  void build();
  bool share_a_corner(std::uint32_t first, std::uint32_t second) const;
  void merge_hits(double tolerance, std::vector<SurfacePoint>& hits) const;
};

void triangle_bounds(const RTCBoundsFunctionArguments* arguments) {
  const auto& data = *static_cast<const IndexData*>(arguments->geometryUserPtr);
  const Triangle& triangle = data.triangles[arguments->primID];
  RTCBounds& bounds = *arguments->bounds_o;
  if (!data.is_finite(triangle)) {
    // An empty box: Embree leaves the triangle out.
    constexpr float kFar = std::numeric_limits<float>::infinity();
    bounds.lower_x = bounds.lower_y = bounds.lower_z = kFar;
    bounds.upper_x = bounds.upper_y = bounds.upper_z = -kFar;
    return;
  }
  const Vec3 a = data.to_local(data.positions[triangle[0]]);
  const Vec3 b = data.to_local(data.positions[triangle[1]]);
  const Vec3 c = data.to_local(data.positions[triangle[2]]);
  bounds.lower_x = static_cast<float>(std::min({a.x, b.x, c.x})) - kBoxMargin;
  bounds.lower_y = static_cast<float>(std::min({a.y, b.y, c.y})) - kBoxMargin;
  bounds.lower_z = static_cast<float>(std::min({a.z, b.z, c.z})) - kBoxMargin;
  bounds.upper_x = static_cast<float>(std::max({a.x, b.x, c.x})) + kBoxMargin;
  bounds.upper_y = static_cast<float>(std::max({a.y, b.y, c.y})) + kBoxMargin;
  bounds.upper_z = static_cast<float>(std::max({a.z, b.z, c.z})) + kBoxMargin;
}

struct RayQuery {
  RTCIntersectContext context;  // first: Embree hands back a pointer to it
  const IndexData* data;
  ShearedRay ray;
  double t_minimum, t_maximum;
  double t_entry;      // the float ray starts here
  double local_per_t;  // length of the direction in Embree's units
  double t_tolerance;  // hits closer than this may be one point
  bool nearest_only;
  double t_nearest;
  std::vector<SurfacePoint>* hits;
};

void ray_meets_box(const RTCIntersectFunctionNArguments* arguments) {
  if (arguments->valid[0] == 0) return;
  auto& query = *reinterpret_cast<RayQuery*>(arguments->context);
  const IndexData& data = *query.data;
  const Triangle& triangle = data.triangles[arguments->primID];
  const Vec3& a = data.positions[triangle[0]];
  const Vec3& b = data.positions[triangle[1]];
  const Vec3& c = data.positions[triangle[2]];
  SurfacePoint hit;
  if (!query.ray.intersect(a, b, c, hit.t, hit.barycentric)) return;
  if (!(hit.t >= query.t_minimum && hit.t <= query.t_maximum)) return;
  if (query.nearest_only) {
    if (hit.t > query.t_nearest + query.t_tolerance) return;
    query.t_nearest = std::min(query.t_nearest, hit.t);
    auto& float_ray = reinterpret_cast<RTCRayHit*>(arguments->rayhit)->ray;
    const double reach = (query.t_nearest + query.t_tolerance - query.t_entry) * query.local_per_t;
    float_ray.tfar = std::min(float_ray.tfar, static_cast<float>(reach * (1 + 1e-6)) + kBoxMargin);
  }
  hit.triangle = arguments->primID;
  hit.position = interpolate(a, b, c, hit.barycentric);
  query.hits->push_back(hit);
}

struct PointQuery {
  const IndexData* data;
  Vec3 point;
  double slack;  // rounding of the query point in Embree's units
  TrianglePoint best;
  std::uint32_t best_triangle;
};

float inflated_radius(double squared_distance, double scale, double slack) {
  const double radius = scale * std::sqrt(squared_distance) * (1 + 1e-6) + slack;
  return radius < std::numeric_limits<float>::max() ? static_cast<float>(radius)
                                                    : std::numeric_limits<float>::infinity();
}

// Strictly nearer wins; at the same distance the lower index.
bool consider_triangle(PointQuery& query, std::uint32_t index) {
  const IndexData& data = *query.data;
  const Triangle& triangle = data.triangles[index];
  const TrianglePoint candidate = closest_point_on_triangle(
      query.point, data.positions[triangle[0]], data.positions[triangle[1]], data.positions[triangle[2]]);
  if (!(candidate.squared_distance <= query.best.squared_distance)) return false;
  const bool nearer = candidate.squared_distance < query.best.squared_distance;
  if (!nearer && index > query.best_triangle) return false;
  query.best = candidate;
  query.best_triangle = index;
  return nearer;
}

bool sphere_meets_box(RTCPointQueryFunctionArguments* arguments) {
  auto& query = *static_cast<PointQuery*>(arguments->userPtr);
  if (!consider_triangle(query, arguments->primID)) return false;
  const float radius = inflated_radius(query.best.squared_distance, query.data->scale, query.slack);
  if (!(radius < arguments->query->radius)) return false;
  arguments->query->radius = radius;
  return true;
}

// The first triangle within the distance decides; a sphere without radius meets hardly anything after that.
bool sphere_meets_any_box(RTCPointQueryFunctionArguments* arguments) {
  auto& query = *static_cast<PointQuery*>(arguments->userPtr);
  if (query.best_triangle == kNoTriangle) consider_triangle(query, arguments->primID);
  if (query.best_triangle == kNoTriangle) return false;
  arguments->query->radius = 0;
  return true;
}

// Clips [t_minimum, t_maximum] to the box |x - center| <= reach, in double.
bool clip_to_box(const Vec3& origin, const Vec3& direction, const Vec3& center, const Vec3& reach,
                 double& t_minimum, double& t_maximum) {
  for (int i = 0; i < 3; ++i) {
    const double low = center[i] - reach[i] - origin[i];
    const double high = center[i] + reach[i] - origin[i];
    if (direction[i] == 0) {
      if (low > 0 || high < 0) return false;
      continue;
    }
    const double t0 = low / direction[i];
    const double t1 = high / direction[i];
    t_minimum = std::max(t_minimum, std::min(t0, t1));
    t_maximum = std::min(t_maximum, std::max(t0, t1));
  }
  return t_minimum <= t_maximum;
}

void IndexData::build() {
  if (triangles.empty()) return;
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Vec3 low{kInfinity, kInfinity, kInfinity}, high = -low;
  for (const Triangle& triangle : triangles) {
    if (!is_finite(triangle)) continue;
    for (const std::uint32_t corner : triangle) {
      const Vec3& p = positions[corner];
      for (int i = 0; i < 3; ++i) {
        low[i] = std::min(low[i], p[i]);
        high[i] = std::max(high[i], p[i]);
      }
    }
  }
  if (!(low.x <= high.x)) return;
  center = 0.5 * low + 0.5 * high;
  half_extent = 0.5 * high - 0.5 * low;
  const double largest = std::max({half_extent.x, half_extent.y, half_extent.z});
  if (largest > 0) scale = std::ldexp(1.0, -std::ilogb(largest) - 1);

  const RTCDevice device = shared_device();
  scene = rtcNewScene(device);
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
  const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(triangles.size()));
  rtcSetGeometryUserData(geometry, this);
  rtcSetGeometryBoundsFunction(
      geometry, [](const RTCBoundsFunctionArguments* arguments) { triangle_bounds(arguments); }, nullptr);
  rtcSetGeometryIntersectFunction(
      geometry, [](const RTCIntersectFunctionNArguments* arguments) { ray_meets_box(arguments); });
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene);
  if (rtcGetDeviceError(device) != RTC_ERROR_NONE) {
    throw Error(ExitCode::kLimit, "not enough memory for the search structure over the triangles");
  }
}

// By position, so that a mesh that is not welded counts as one surface here.
bool IndexData::share_a_corner(std::uint32_t first, std::uint32_t second) const {
  for (const std::uint32_t a : triangles[first]) {
    for (const std::uint32_t b : triangles[second]) {
      if (a == b || positions[a] == positions[b]) return true;
    }
  }
  return false;
}

// A ray through an edge or a vertex meets every triangle around it at one point; the lowest index stands for
// all.
void IndexData::merge_hits(double tolerance, std::vector<SurfacePoint>& hits) const {
  std::sort(hits.begin(), hits.end(), [](const SurfacePoint& a, const SurfacePoint& b) {
    return a.t != b.t ? a.t < b.t : a.triangle < b.triangle;
  });
  std::size_t kept = 0;
  for (const SurfacePoint& hit : hits) {
    bool merged = false;
    if (on_boundary(hit)) {
      for (std::size_t i = kept; i-- > 0 && !merged && hit.t - hits[i].t <= tolerance;) {
        if (!on_boundary(hits[i]) || !share_a_corner(hit.triangle, hits[i].triangle)) continue;
        if (hit.triangle < hits[i].triangle) {
          const double t_first = hits[i].t;
          hits[i] = hit;
          hits[i].t = t_first;
        }
        merged = true;
      }
    }
    if (!merged) hits[kept++] = hit;
  }
  hits.resize(kept);
}

// All hits in [t_minimum, t_maximum], or those that may be the nearest one; merged and sorted.
void find_hits(const IndexData& data, const Vec3& origin, const Vec3& direction, double t_minimum,
               double t_maximum, bool nearest_only, std::vector<SurfacePoint>& hits) {
  hits.clear();
  if (data.scene == nullptr || direction == Vec3{} || !is_finite(direction) || !is_finite(origin)) return;
  double t_entry = t_minimum, t_exit = t_maximum;
  const double margin = 4 * kBoxMargin / data.scale;
  const Vec3 reach = data.half_extent + Vec3{margin, margin, margin};
  if (!clip_to_box(origin, direction, data.center, reach, t_entry, t_exit)) return;

  // The largest distance, in units of t, that rounding can put between two hits of one point.
  const double coordinate =
      std::max({std::abs(origin.x), std::abs(origin.y), std::abs(origin.z), 1 / data.scale,
                std::abs(data.center.x), std::abs(data.center.y), std::abs(data.center.z)});
  const double length = norm(direction);
  const double tolerance = 256 * std::numeric_limits<double>::epsilon() * coordinate / length;

  RayQuery query{{},
                 &data,
                 ShearedRay(origin, direction),
                 t_minimum,
                 t_maximum,
                 t_entry,
                 length * data.scale,
                 tolerance,
                 nearest_only,
                 t_maximum,
                 &hits};
  rtcInitIntersectContext(&query.context);
  const Vec3 start = data.to_local(origin + t_entry * direction);
  const Vec3 unit = direction / length;
  RTCRayHit ray{};
  ray.ray.org_x = static_cast<float>(start.x);
  ray.ray.org_y = static_cast<float>(start.y);
  ray.ray.org_z = static_cast<float>(start.z);
  ray.ray.dir_x = static_cast<float>(unit.x);
  ray.ray.dir_y = static_cast<float>(unit.y);
  ray.ray.dir_z = static_cast<float>(unit.z);
  ray.ray.tnear = 0;
  ray.ray.tfar = static_cast<float>((t_exit - t_entry) * query.local_per_t) + 4 * kBoxMargin;
  ray.ray.mask = ~0u;
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(data.scene, &query.context, &ray);
  data.merge_hits(tolerance, hits);
}

}  // namespace

struct SurfaceIndex::Implementation : IndexData {};

SurfaceIndex::SurfaceIndex(const TriangleMesh& mesh) : SurfaceIndex(mesh.positions, mesh.triangles) {}

SurfaceIndex::SurfaceIndex(const std::vector<Vec3>& positions, const std::vector<Triangle>& triangles)
    : implementation_(std::make_unique<Implementation>()) {
  implementation_->positions = positions;
  implementation_->triangles = triangles;
  implementation_->build();
}

SurfaceIndex::~SurfaceIndex() = default;
SurfaceIndex::SurfaceIndex(SurfaceIndex&&) noexcept = default;
SurfaceIndex& SurfaceIndex::operator=(SurfaceIndex&&) noexcept = default;

const std::vector<Vec3>& SurfaceIndex::positions() const { return implementation_->positions; }
const std::vector<Triangle>& SurfaceIndex::triangles() const { return implementation_->triangles; }

void SurfaceIndex::all_hits(const Vec3& origin, const Vec3& direction, double t_minimum, double t_maximum,
                            int maximum_count, std::vector<SurfacePoint>& hits) const {
  find_hits(*implementation_, origin, direction, t_minimum, t_maximum, false, hits);
  const std::size_t limit = static_cast<std::size_t>(std::max(maximum_count, 0));
  if (hits.size() > limit) hits.resize(limit);
}

SurfacePoint SurfaceIndex::first_hit(const Vec3& origin, const Vec3& direction, double t_minimum,
                                     double t_maximum) const {
  thread_local std::vector<SurfacePoint> hits;
  find_hits(*implementation_, origin, direction, t_minimum, t_maximum, true, hits);
  return hits.empty() ? SurfacePoint{} : hits.front();
}

namespace {

// The query after all triangles that its callback let it visit.
PointQuery visit_near_triangles(const IndexData& data, const Vec3& point, double maximum_distance,
                                RTCPointQueryFunction visit) {
  const Vec3 local = data.to_local(point);
  const double farthest = std::max({std::abs(local.x), std::abs(local.y), std::abs(local.z)});
  PointQuery query{
      &data, point, farthest * 0x1p-21, {{0, 0, 0}, maximum_distance * maximum_distance}, kNoTriangle};
  if (farthest < kFarthestFloatPoint) {
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    RTCPointQuery sphere{};
    sphere.x = static_cast<float>(local.x);
    sphere.y = static_cast<float>(local.y);
    sphere.z = static_cast<float>(local.z);
    sphere.radius = inflated_radius(query.best.squared_distance, data.scale, query.slack);
    rtcPointQuery(data.scene, &sphere, &context, visit, &query);
  } else {
    for (std::uint32_t i = 0; i < data.triangles.size(); ++i) consider_triangle(query, i);
  }
  return query;
}

}  // namespace

bool SurfaceIndex::is_within(const Vec3& point, double distance) const {
  const IndexData& data = *implementation_;
  if (data.scene == nullptr || !is_finite(point) || !(distance >= 0)) return false;
  return visit_near_triangles(data, point, distance, sphere_meets_any_box).best_triangle != kNoTriangle;
}

SurfacePoint SurfaceIndex::closest_point(const Vec3& point, double maximum_distance) const {
  const IndexData& data = *implementation_;
  SurfacePoint nearest;
  if (data.scene == nullptr || !is_finite(point) || !(maximum_distance >= 0)) return nearest;
  const PointQuery query = visit_near_triangles(data, point, maximum_distance, sphere_meets_box);
  if (query.best_triangle == kNoTriangle) return nearest;

  const Triangle& triangle = data.triangles[query.best_triangle];
  nearest.triangle = query.best_triangle;
  std::copy_n(query.best.barycentric, 3, nearest.barycentric);
  nearest.position = interpolate(data.positions[triangle[0]], data.positions[triangle[1]],
                                 data.positions[triangle[2]], nearest.barycentric);
  nearest.t = std::sqrt(query.best.squared_distance);
  return nearest;
}

}  // namespace nmc

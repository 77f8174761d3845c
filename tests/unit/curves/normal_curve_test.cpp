// SPDX-License-Identifier: Apache-2.0
#include "encoder/curves/normal_curve.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "encoder/core/error.h"
#include "encoder/curves/curve_least_squares.h"

using namespace nmc;

namespace {

constexpr double kTau = 2 * std::numbers::pi;

ReferenceCurve wavy_circle(int points, double amplitude, int waves) {
  std::vector<Vec3> p;
  for (int i = 0; i < points; ++i) {
    const double t = kTau * i / points, r = 1 + amplitude * std::sin(waves * t);
    p.push_back({r * std::cos(t), r * std::sin(t), 0});
  }
  return {std::move(p), true};
}

ReferenceCurve knot_in_space(int points) {
  std::vector<Vec3> p;
  for (int i = 0; i < points; ++i) {
    const double t = kTau * i / points;
    p.push_back({std::sin(t) + 2 * std::sin(2 * t), std::cos(t) - 2 * std::cos(2 * t), -std::sin(3 * t)});
  }
  return {std::move(p), true};
}

std::vector<double> even_base(int count) {
  std::vector<double> base;
  for (int i = 0; i < count; ++i) base.push_back(static_cast<double>(i) / count);
  return base;
}

double largest_difference(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  REQUIRE(a.size() == b.size());
  double worst = 0;
  for (std::size_t i = 0; i < a.size(); ++i) worst = std::max(worst, distance(a[i], b[i]));
  return worst;
}

}  // namespace

TEST_CASE("the parameter of a curve is its arc length, and a closed one repeats") {
  const ReferenceCurve square({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, true);
  CHECK(square.length() == 4);
  CHECK(distance(square(0.375), {1, 0.5, 0}) < 1e-15);
  CHECK(distance(square(1.375), {1, 0.5, 0}) < 1e-15);
  CHECK(distance(square(-0.125), {0, 0.5, 0}) < 1e-15);
  std::vector<double> crossings;
  square.crossings({0.25, 0, 0}, {1, 0, 0}, 0.5, 1.25, crossings);
  // Down through the top side and again along the bottom one after the turn.
  REQUIRE(crossings.size() == 2);
  CHECK(crossings[0] == Approx(0.6875));
  CHECK(crossings[1] == Approx(1.0625));
}

TEST_CASE("curves without length or with too few points are refused") {
  CHECK_THROWS_AS(ReferenceCurve({{0, 0, 0}}, false), Error);
  CHECK_THROWS_AS(ReferenceCurve({{1, 1, 1}, {1, 1, 1}}, false), Error);
}

TEST_CASE("the stencils reproduce polynomials of their order") {
  const auto points = [](int degree) {
    std::vector<Vec3> p;
    for (int i = 0; i < 8; ++i) p.push_back({static_cast<double>(i), std::pow(i - 3.5, degree), 0});
    return p;
  };
  const auto error = [&](CurvePredictor predictor, int degree) {
    return std::abs(predict_position(points(degree), 3, false, predictor).y - std::pow(0.0, degree));
  };
  CHECK(error(CurvePredictor::kMidpoint, 1) < 1e-13);
  CHECK(error(CurvePredictor::kMidpoint, 2) > 0.1);
  CHECK(error(CurvePredictor::kFourPoint, 2) < 1e-13);
  CHECK(error(CurvePredictor::kFourPoint, 4) > 0.1);
  CHECK(error(CurvePredictor::kSixPoint, 4) < 1e-12);
}

TEST_CASE(
    "details alone reconstruct interpolating, variational and sombrero curves in the plane and in space") {
  for (const int dimension : {2, 3}) {
    const ReferenceCurve reference = dimension == 2 ? wavy_circle(3000, 0.3, 7) : knot_in_space(3000);
    for (const CurveFit fit : {CurveFit::kInterpolating, CurveFit::kVariational, CurveFit::kSombrero}) {
      for (const CurvePredictor predictor :
           {CurvePredictor::kMidpoint, CurvePredictor::kFourPoint, CurvePredictor::kSixPoint}) {
        NormalCurveOptions options;
        options.dimension = dimension;
        options.fit = fit;
        options.predictor = predictor;
        options.level_count = fit == CurveFit::kSombrero ? 2 : 5;
        const NormalCurve curve = build_normal_curve(reference, even_base(12), options);
        INFO("dimension " << dimension << " fit " << static_cast<int>(fit) << " predictor "
                          << static_cast<int>(predictor));
        CHECK(largest_difference(reconstruct(curve), curve.levels.back().positions) < 1e-11);
        if (dimension == 2)
          for (const CurveDetail& d : curve.levels.back().details) CHECK(d.normal[1] == 0);
      }
    }
  }
}

TEST_CASE("interpolating vertices lie on the reference, at their parameters, which ascend") {
  const ReferenceCurve reference = wavy_circle(3000, 0.3, 9);
  const NormalCurve curve = build_normal_curve(reference, even_base(8), {});
  const NormalCurveLevel& finest = curve.levels.back();
  for (std::size_t i = 0; i < finest.positions.size(); ++i) {
    CHECK(distance(finest.positions[i], reference(finest.parameters[i])) < 1e-12);
    if (i > 0) CHECK(finest.parameters[i] > finest.parameters[i - 1]);
  }
}

TEST_CASE("an aperture of zero makes every vertex a vector, a wide one nearly none") {
  const ReferenceCurve reference = wavy_circle(3001, 0.4, 11);
  const auto non_normal = [&](double aperture) {
    NormalCurveOptions options;
    options.aperture = aperture;
    std::size_t count = 0;
    for (const NormalCurveLevel& level : build_normal_curve(reference, even_base(7), options).levels)
      count += level.non_normal_count;
    return count;
  };
  const std::size_t all = 7 * ((1 << 5) - 1);
  CHECK(non_normal(1e-9) > all * 9 / 10);
  CHECK(non_normal(0.2) > non_normal(0.43));
  CHECK(non_normal(0.9) < all / 50);
}

TEST_CASE("the variational curve is the best on its normal lines, and free vectors are better still") {
  const ReferenceCurve reference = wavy_circle(4000, 0.25, 13);
  const auto errors = [&](CurveFit fit) {
    NormalCurveOptions options;
    options.fit = fit;
    std::vector<double> e;
    for (const NormalCurveLevel& level : build_normal_curve(reference, even_base(8), options).levels)
      e.push_back(parametric_error(reference, level, true));
    return e;
  };
  const std::vector<double> interpolating = errors(CurveFit::kInterpolating);
  const std::vector<double> variational = errors(CurveFit::kVariational);
  const std::vector<double> vectorial = errors(CurveFit::kVectorial);
  for (std::size_t l = 1; l < interpolating.size(); ++l) {
    INFO("level " << l);
    CHECK(variational[l] < interpolating[l]);
    // The two reparameterizations differ, so free vectors win only up to that.
    CHECK(vectorial[l] < 1.1 * variational[l]);
  }
  // A small move along any normal makes the error larger.
  NormalCurveOptions options;
  options.fit = CurveFit::kVariational;
  NormalCurveLevel level = build_normal_curve(reference, even_base(8), options).levels.back();
  const double best = parametric_error(reference, level, true);
  for (std::size_t i = 0; i < level.positions.size(); i += 17) {
    for (const double step : {-1e-4, 1e-4}) {
      NormalCurveLevel moved = level;
      moved.positions[i] += step * level.frames[i].normal[0];
      CHECK(parametric_error(reference, moved, true) > best);
    }
  }
}

TEST_CASE("on a smooth curve the offsets shrink with the order of the predictor") {
  const ReferenceCurve reference = wavy_circle(200000, 0.2, 3);
  const auto decay = [&](CurvePredictor predictor) {
    NormalCurveOptions options;
    options.predictor = predictor;
    options.level_count = 6;
    const NormalCurve curve = build_normal_curve(reference, even_base(16), options);
    const auto largest = [&](int l) {
      double value = 0;
      const NormalCurveLevel& level = curve.levels[static_cast<std::size_t>(l)];
      for (std::size_t i = 1; i < level.details.size(); i += 2)
        value = std::max(value, std::abs(level.details[i].normal[0]));
      return value;
    };
    return std::log2(largest(3) / largest(5)) / 2;
  };
  // [DRS04], Theorem 3.6: second order for the midpoint rule, more for the others.
  CHECK(decay(CurvePredictor::kMidpoint) == Approx(2).margin(0.1));
  CHECK(decay(CurvePredictor::kFourPoint) > 2.7);
}

TEST_CASE("an open curve keeps its ends") {
  std::vector<Vec3> points;
  for (int i = 0; i <= 500; ++i) points.push_back({i / 100.0, std::sin(i / 40.0), 0});
  const ReferenceCurve reference(std::move(points), false);
  for (const CurvePredictor predictor :
       {CurvePredictor::kMidpoint, CurvePredictor::kFourPoint, CurvePredictor::kSixPoint}) {
    NormalCurveOptions options;
    options.predictor = predictor;
    const NormalCurve curve = build_normal_curve(reference, {0, 0.3, 0.6, 1}, options);
    CHECK(curve.levels.back().positions.size() == 3 * 32 + 1);
    CHECK(curve.levels.back().positions.front() == reference(0));
    CHECK(curve.levels.back().positions.back() == reference(1));
    CHECK(geometric_error(reference, curve.levels.back(), false) < 5e-3);
  }
}

TEST_CASE("the integrals of the hats are those of linear elements on a straight reference") {
  const ReferenceCurve reference({{0, 0, 0}, {4, 0, 0}}, false);
  NormalCurveLevel level;
  level.parameters = {0, 0.25, 0.5, 0.75, 1};
  for (const double u : level.parameters) level.positions.push_back({4 * u, 1, 0});
  const CurveIntegrals integrals = integrate(reference, level, false);
  CHECK(integrals.mass[0] == Approx(1.0 / 3));
  CHECK(integrals.mass[1] == Approx(2.0 / 3));
  CHECK(integrals.mass_right[2] == Approx(1.0 / 6));
  CHECK(integrals.load[1].y == Approx(-1));
  CHECK(integrals.squared_error == Approx(4));
}

// SPDX-License-Identifier: Apache-2.0
#include "encoder/sphere/exact_orientation.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

using namespace nmc;

TEST_CASE("the orientation of well-shaped triangles is that of the determinant") {
  CHECK(orientation_sign({1, 0, 0}, {0, 1, 0}, {0, 0, 1}) == 1);
  CHECK(orientation_sign({0, 1, 0}, {1, 0, 0}, {0, 0, 1}) == -1);
}

TEST_CASE(
    "linearly dependent vectors have orientation zero, and one unit in the last place decides otherwise") {
  const Vec3 a{0.1, 0.2, 0.3}, b{0.7, 0.5, 0.11};
  // 2 a and 4 b are exact, so the determinant is exactly zero although its terms round.
  CHECK(orientation_sign(a, b, 2 * a) == 0);
  CHECK(orientation_sign(a, 4 * b, b) == 0);
  for (int k = 0; k < 3; ++k) {
    for (const double direction : {-1.0, 1.0}) {
      Vec3 c = 2 * a;
      c[k] = std::nextafter(c[k], direction * std::numeric_limits<double>::infinity());
      // det(a, b, e_k) by cofactors: its sign is safe in doubles.
      const Vec3 cofactors = cross(a, b);
      const int expected = cofactors[k] * direction > 0 ? 1 : -1;
      INFO("component " << k << " direction " << direction);
      CHECK(orientation_sign(a, b, c) == expected);
    }
  }
}

TEST_CASE("orientation is antisymmetric and cyclic where doubles cannot decide") {
  const Vec3 a{1.0 / 3, 2.0 / 3, 2.0 / 3};
  const Vec3 b = normalized(a + Vec3{1e-17, -1e-16, 1e-16}), c = normalized(a + Vec3{-2e-16, 1e-16, 1e-17});
  const int sign = orientation_sign(a, b, c);
  CHECK(orientation_sign(b, c, a) == sign);
  CHECK(orientation_sign(c, a, b) == sign);
  CHECK(orientation_sign(b, a, c) == -sign);
}

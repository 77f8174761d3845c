// SPDX-License-Identifier: Apache-2.0
// g++ 12 vectorizes neighbouring conversions double -> float -> double and drops them both (-ftree-slp-vectorize,
// part of -O2). The exact rooms are compiled without that pass; this program is compiled as they are.
#include <catch2/catch.hpp>

namespace {

struct Triple {
  double x, y, z;
};

[[gnu::noinline]] Triple rounded(const Triple& a) {
  return {static_cast<double>(static_cast<float>(a.x)), static_cast<double>(static_cast<float>(a.y)),
          static_cast<double>(static_cast<float>(a.z))};
}

}  // namespace

TEST_CASE("exact rooms: a double rounded to float stays rounded in every member of a structure", "[determinism]") {
  const Triple result = rounded({0.1, 0.2, 0.3});
  volatile float x = 0.1f, y = 0.2f, z = 0.3f;
  CHECK(result.x == static_cast<double>(x));
  CHECK(result.y == static_cast<double>(y));
  CHECK(result.z == static_cast<double>(z));
}

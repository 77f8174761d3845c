// SPDX-License-Identifier: Apache-2.0
#include "encoder/sphere/exact_orientation.h"

#include <array>
#include <cmath>
#include <limits>

namespace nmc {

namespace {

// A value as an unevaluated sum of doubles that do not overlap, smallest first (Shewchuk's expansion).
struct Expansion {
  // Six triple products of four components each, added one component at a time, never need more.
  std::array<double, 32> terms{};
  int count = 0;

  // GROW-EXPANSION with zero elimination: exact, keeps the components non-overlapping and increasing.
  void add(double value) {
    double carry = value;
    int kept = 0;
    for (int i = 0; i < count; ++i) {
      const double term = terms[i];
      const double sum = carry + term;
      const double term_part = sum - carry;
      const double error = (carry - (sum - term_part)) + (term - term_part);
      if (error != 0) terms[kept++] = error;
      carry = sum;
    }
    if (carry != 0) terms[kept++] = carry;
    count = kept;
  }

  // The largest component dominates the sum of all others.
  int sign() const { return count == 0 ? 0 : terms[count - 1] > 0 ? 1 : -1; }
};

void add_triple_product(Expansion& sum, double a, double b, double c) {
  const double high = a * b;
  const double low = std::fma(a, b, -high);
  for (const double factor : {low, high}) {
    const double product = factor * c;
    sum.add(std::fma(factor, c, -product));
    sum.add(product);
  }
}

}  // namespace

int orientation_sign(const Vec3& a, const Vec3& b, const Vec3& c) {
  const double xy = a.x * b.y, yx = a.y * b.x, yz = a.y * b.z, zy = a.z * b.y, zx = a.z * b.x, xz = a.x * b.z;
  const double determinant = c.z * (xy - yx) + c.x * (yz - zy) + c.y * (zx - xz);
  const double permanent = std::abs(c.z) * (std::abs(xy) + std::abs(yx)) +
                           std::abs(c.x) * (std::abs(yz) + std::abs(zy)) +
                           std::abs(c.y) * (std::abs(zx) + std::abs(xz));
  // Shewchuk's o3derrboundA: (7 + 56 eps) eps with eps = 2^-53; his differences are exact here.
  constexpr double kHalfUlp = std::numeric_limits<double>::epsilon() / 2;
  constexpr double kErrorBound = (7 + 56 * kHalfUlp) * kHalfUlp;
  if (determinant > kErrorBound * permanent) return 1;
  if (-determinant > kErrorBound * permanent) return -1;

  Expansion exact;
  add_triple_product(exact, a.x, b.y, c.z);
  add_triple_product(exact, -a.y, b.x, c.z);
  add_triple_product(exact, a.y, b.z, c.x);
  add_triple_product(exact, -a.z, b.y, c.x);
  add_triple_product(exact, a.z, b.x, c.y);
  add_triple_product(exact, -a.x, b.z, c.y);
  return exact.sign();
}

}  // namespace nmc

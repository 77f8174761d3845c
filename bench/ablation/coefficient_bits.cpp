// SPDX-License-Identifier: Apache-2.0
#include "bench/ablation/coefficient_bits.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <vector>

#include "encoder/core/error.h"
#include "libnmc/common/coefficient_coder.h"
#include "libnmc/encode/range_encoder.h"

namespace nmc_bench {

using namespace nmc;

namespace {

constexpr int kLevelClasses = 8, kClasses = 11, kUnary = 14;

/// One adaptive bit per decision.
class OneContextCoder {
 public:
  OneContextCoder() {
    for (auto& level : zero_)
      for (AdaptiveBit& bit : level) bit.state = AdaptiveBit::kUntrained;
    for (auto& of_class : larger_)
      for (AdaptiveBit& bit : of_class) bit.state = AdaptiveBit::kUntrained;
    sign_.state = AdaptiveBit::kUntrained;
  }

  void code(int level, int energy_class, std::int32_t value) {
    const auto k = static_cast<std::size_t>(energy_class);
    code(zero_[std::min(level, kLevelClasses - 1)][k], value != 0, kSignificanceCountLimit);
    if (value == 0) return;
    code(sign_, value < 0, kSignificanceCountLimit);
    const int excess = std::abs(value) - 1;
    for (int m = 0; m < kUnary; ++m) {
      code(larger_[k][m], excess > m, kMagnitudeCountLimit);
      if (excess <= m) return;
    }
    escape_bits_ += 2 * std::floor(std::log2(excess - kUnary + 1.0)) + 1;  // Elias gamma
  }
  double bits() const { return counter_.bits() + escape_bits_; }

 private:
  void code(AdaptiveBit& state, bool bit, std::uint32_t count_limit) {
    counter_.code(bit, std::clamp(state.probability_16(), 32u, 65504u));
    state.update(bit, count_limit);
  }

  AdaptiveBit zero_[kLevelClasses][kClasses], larger_[kClasses][kUnary], sign_;
  BitCounter counter_;
  double escape_bits_ = 0;
};

/// The main context of the edge: a mean of the edges coded before it that share a face with it, of the
/// coefficients of its ends, and of the opposite vertices, in sixteenths.
int main_context(int level, const LevelTopology& topology, std::uint32_t edge,
                 const std::vector<std::int32_t>& vertex_values, const std::vector<std::int32_t>& values) {
  std::int32_t near_sum = 0, near_count = 0, opposite_sum = 0;
  for (std::uint32_t side = 0; side < 2; ++side) {
    const std::uint32_t face = topology.edge_faces[2 * edge + side];
    if (face == kNone) continue;
    opposite_sum +=
        coefficient_internal::context_magnitude(vertex_values[topology.opposite_vertex(edge, face)]);
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t near = topology.face_edges[3 * face + k];
      if (near >= edge) continue;
      near_sum += coefficient_internal::context_magnitude(values[near]);
      ++near_count;
    }
  }
  std::int32_t parent_sum = 0;
  for (std::uint32_t i = 0; i < 2; ++i)
    parent_sum +=
        coefficient_internal::context_magnitude(vertex_values[topology.edge_vertices[2 * edge + i]]);
  if (level == 0) return coefficient_internal::energy_class(near_count ? 16 * near_sum / near_count : 16);
  const std::int32_t inherited = 64 * parent_sum + 24 * opposite_sum;
  return coefficient_internal::energy_class(near_count ? (320 * near_sum / near_count + inherited) / 31
                                                       : inherited / 11);
}

}  // namespace

CoefficientBits coefficient_bits(const QuantizedMesh& mesh, const SubdivisionHierarchy& hierarchy) {
  OneContextCoder one_context;
  BitCounter coded, untrained;
  // The models are tables of many kilobytes.
  const auto trained_model = std::make_unique<CoefficientModel>();
  const auto untrained_model = std::make_unique<CoefficientModel>();
  untrained_model->reset_untrained();
  std::vector<std::int32_t> vertex_values(hierarchy.level(0).vertex_count, 0);
  for (int l = 0; l < mesh.level_count(); ++l) {
    const std::vector<std::int32_t>& values = mesh.normal[static_cast<std::size_t>(l)];
    const LevelTopology& topology = hierarchy.level(l);
    LevelCoefficients coefficients;
    if (!coefficients.normal.resize(values.size())) throw Error(ExitCode::kLimit, "out of memory");
    std::copy(values.begin(), values.end(), coefficients.normal.begin());
    const LevelTopology* coarse = l > 0 ? &hierarchy.level(l - 1) : nullptr;
    for (const auto& [model, counter] :
         {std::pair(trained_model.get(), &coded), std::pair(untrained_model.get(), &untrained)}) {
      if (!model
               ->code_level(*counter, nullptr, l, coarse, topology, vertex_values.data(), nullptr,
                            coefficients)
               .ok())
        throw Error(ExitCode::kInternal, "the coefficients cannot be coded");
    }
    for (std::uint32_t e = 0; e < topology.edge_count; ++e)
      one_context.code(l, main_context(l, topology, e, vertex_values, values), values[e]);
    vertex_values.insert(vertex_values.end(), values.begin(), values.end());
  }
  return {one_context.bits(), untrained.bits(), coded.bits()};
}

}  // namespace nmc_bench

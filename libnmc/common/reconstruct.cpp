// SPDX-License-Identifier: Apache-2.0
#include "libnmc/common/reconstruct.h"

#include <algorithm>

#include "libnmc/common/local_frame.h"

namespace nmc {

void reconstruct_odd_vertices(const LevelTopology& coarse, const RingWeights& ring_weights,
                              const LevelQuantizer& quantizer, const LevelCoefficients* coefficients,
                              std::uint32_t first_edge, std::uint32_t last_edge, Vec3* positions) {
  const TangentialCoefficient* tangential = nullptr;
  const TangentialCoefficient* tangential_end = nullptr;
  if (coefficients) {
    tangential_end = coefficients->tangential.end();
    tangential = std::lower_bound(coefficients->tangential.begin(), tangential_end, first_edge,
                                  [](const TangentialCoefficient& t, std::uint32_t edge) { return t.edge < edge; });
  }
  Vec3* odd = positions + coarse.vertex_count;
  for (std::uint32_t edge = first_edge; edge < last_edge; ++edge) {
    Vec3 p = predict_odd_vertex(coarse, ring_weights, edge, quantizer.tension, positions);
    if (coefficients) {
      const std::int32_t c = coefficients->normal[edge];
      const bool has_tangential = tangential != tangential_end && tangential->edge == edge;
      if (has_tangential) {
        const LocalFrame frame = odd_vertex_frame(coarse, edge, positions);
        p = p + (static_cast<double>(c) * quantizer.normal_step) * frame.normal;
        p = p + (static_cast<double>(tangential->along) * quantizer.tangential_step) * frame.along;
        p = p + (static_cast<double>(tangential->across) * quantizer.tangential_step) * frame.across;
        ++tangential;
      } else if (c != 0) {
        p = p + (static_cast<double>(c) * quantizer.normal_step) * odd_vertex_normal(coarse, edge, positions);
      }
    }
    odd[edge] = p;
  }
}

}  // namespace nmc

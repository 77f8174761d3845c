// SPDX-License-Identifier: Apache-2.0
#include "encoder/fit/quality_layers.h"

#include <cmath>

namespace nmc {

std::vector<QuantizedMesh> quantize_layers(const LayerOptions& options, MeshQuantizer& quantizer,
                                           std::vector<QuantizeReport>* reports) {
  std::vector<QuantizedMesh> layers;
  if (reports) reports->assign(static_cast<std::size_t>(options.layer_count), {});
  QuantizeOptions coarsest = options.finest;
  double span = 1;
  for (int k = 1; k < options.layer_count; ++k) span *= options.ratio;
  coarsest.normal_step *= span;
  coarsest.base_step_factor /= options.base_refinement > 0 ? options.base_refinement : std::sqrt(span);
  if (options.layer_count > 1) coarsest.base_pull = options.base_pull;
  QuantizeOptions finer = options.finest;
  finer.base_step_factor = coarsest.base_step_factor;
  for (int k = 0; k < options.layer_count; ++k) {
    QuantizeReport* report = reports ? &(*reports)[static_cast<std::size_t>(k)] : nullptr;
    layers.push_back(k == 0 ? quantizer.quantize(coarsest, report)
                            : quantizer.refine(layers.back(), options.ratio, finer, report));
  }
  return layers;
}

}  // namespace nmc

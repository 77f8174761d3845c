// SPDX-License-Identifier: Apache-2.0
#include "encoder/fit/quality_layers.h"

namespace nmc {

std::vector<QuantizedMesh> quantize_layers(const LayerOptions& options, MeshQuantizer& quantizer,
                                           std::vector<QuantizeReport>* reports) {
  std::vector<QuantizedMesh> layers;
  if (reports) reports->assign(static_cast<std::size_t>(options.layer_count), {});
  QuantizeOptions coarsest = options.finest;
  for (int k = 1; k < options.layer_count; ++k) coarsest.normal_step *= options.ratio;
  for (int k = 0; k < options.layer_count; ++k) {
    QuantizeReport* report = reports ? &(*reports)[static_cast<std::size_t>(k)] : nullptr;
    layers.push_back(k == 0 ? quantizer.quantize(coarsest, report)
                            : quantizer.refine(layers.back(), options.ratio, options.finest, report));
  }
  return layers;
}

}  // namespace nmc

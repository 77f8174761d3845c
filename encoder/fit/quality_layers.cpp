// SPDX-License-Identifier: Apache-2.0
#include "encoder/fit/quality_layers.h"

namespace nmc {

std::vector<QuantizedMesh> quantize_layers(const LayerOptions& options, MeshQuantizer& quantizer,
                                           std::vector<QuantizeReport>* reports) {
  const auto count = static_cast<std::size_t>(options.layer_count);
  std::vector<QuantizedMesh> layers(count);
  if (reports) reports->assign(count, {});
  const auto report_of = [&](std::size_t k) { return reports ? &(*reports)[k] : nullptr; };
  layers.back() = quantizer.quantize(options.finest, report_of(count - 1));
  for (std::size_t k = count - 1; k-- > 0;)
    layers[k] = quantizer.coarsen(layers[k + 1], options.ratio, options.finest, report_of(k));
  const auto polish = [&](std::size_t k) {
    layers[k] = quantizer.polish(layers[k], k > 0 ? &layers[k - 1] : nullptr,
                                 k + 1 < count ? &layers[k + 1] : nullptr, options.ratio, options.finest,
                                 report_of(k));
  };
  for (int round = 0; round < options.polish_rounds; ++round) {
    for (std::size_t k = 1; k < count; ++k) polish(k);
    if (round + 1 == options.polish_rounds) break;
    for (std::size_t k = count - 1; k-- > 0;) polish(k);
  }
  return layers;
}

}  // namespace nmc

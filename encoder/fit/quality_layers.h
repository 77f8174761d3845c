// SPDX-License-Identifier: Apache-2.0
// Quality layers: one file for all rates.
//
// Layer k refines the integers of all levels to steps that are an integer ratio finer than those of layer k -
// 1, and codes q_k - ratio q_{k-1}. What a layer says that the next one does not confirm is lost. So the last
// layer is made first, as a file of one layer would be; the layer before it is made for it: its base vertices
// are those of the later layer, rounded, and its integers pay for the corrections that they leave to the
// later one. It is nevertheless closed by the fit at its own steps. Then the layers are polished in turn,
// each between its neighbours.
//
// Based on: Equitz, Cover, Successive refinement of information, IEEE Trans. Inf. Theory 37(2), 1991.
#ifndef NMC_ENCODER_FIT_QUALITY_LAYERS_H_
#define NMC_ENCODER_FIT_QUALITY_LAYERS_H_

#include <vector>

#include "encoder/fit/quantize.h"

namespace nmc {

struct LayerOptions {
  QuantizeOptions finest;  // of the last layer
  int layer_count = 1;
  int ratio = 3;  // between the steps of neighbouring layers, >= 2
  /// How often all layers are polished, from the second to the last; between two of these, back to the first.
  int polish_rounds = 2;
};

/// One mesh per layer, coarse to fine; each one complete. Their steps are finest.normal_step * ratio^(K - 1 -
/// k). `reports` gets one report per layer.
std::vector<QuantizedMesh> quantize_layers(const LayerOptions& options, MeshQuantizer& quantizer,
                                           std::vector<QuantizeReport>* reports = nullptr);

}  // namespace nmc

#endif  // NMC_ENCODER_FIT_QUALITY_LAYERS_H_

// SPDX-License-Identifier: Apache-2.0
// Quality layers: one file for all rates.
//
// Layer k refines the integers of all levels to steps that are an integer ratio finer than those of layer k -
// 1, and codes q_k - ratio q_{k-1}. Each layer is a complete quantization of its own, closed by the fit at
// its own steps, so a reader who stops after it sees the best mesh for those bytes and nothing drifts; what
// ties a layer to the previous one is only its rate model, which charges differences.
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
  /// The base is coded with the first layer and hardly ever corrected, so its grid is this much finer than
  /// the steps of that layer ask for; 0: the square root of the ratio between the first and the last layer.
  double base_refinement = 0;
  /// Pull of the first layer's base towards its place in the unquantized fit (QuantizeOptions::base_pull).
  double base_pull = 1;
};

/// One mesh per layer, coarse to fine; each one complete. Their steps are finest.normal_step * ratio^(K - 1 -
/// k). `reports` gets one report per layer.
std::vector<QuantizedMesh> quantize_layers(const LayerOptions& options, MeshQuantizer& quantizer,
                                           std::vector<QuantizeReport>* reports = nullptr);

}  // namespace nmc

#endif  // NMC_ENCODER_FIT_QUALITY_LAYERS_H_

// SPDX-License-Identifier: Apache-2.0
#include "libnmc/common/attribute_coder.h"

namespace nmc {

void AttributeModel::reset() {
  forget_all_bits(*this);
  for (MixerWeights& weights : open_.mixer) weights.reset(5);
  for (ComponentStates& states : components_) {
    for (MixerWeights& weights : states.zero_mixer) weights.reset(5);
    states.sign_mixer.reset(3);
    for (MixerWeights& weights : states.more_mixer) weights.reset(4);
  }
  history_ = 0;
}

}  // namespace nmc

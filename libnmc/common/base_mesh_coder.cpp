// SPDX-License-Identifier: Apache-2.0
#include "libnmc/common/base_mesh_coder.h"

namespace nmc {

BaseMeshModel::BaseMeshModel() {
  forget_all_bits(*this);
  parallelogram_share_ = 3;
  last_spread_ = 0;
  visit_trained_states(TrainedStateReader(kTrainedBaseStates));
  visit_trained_mixers(set_trained_weights);
}

void BaseMeshModel::reset_untrained() {
  visit_trained_states([](AdaptiveBit* states, int states_per_level, int level_count, int) {
    for (int i = 0; i < states_per_level * level_count; ++i) states[i].state = AdaptiveBit::kUntrained;
  });
  is_new_mixer_.reset(3);
}

}  // namespace nmc

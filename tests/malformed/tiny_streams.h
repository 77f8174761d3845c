// SPDX-License-Identifier: Apache-2.0
// The streams that the suites of this folder break in every way.
#ifndef NMC_TESTS_MALFORMED_TINY_STREAMS_H_
#define NMC_TESTS_MALFORMED_TINY_STREAMS_H_

#include <vector>

#include "tests/support/stream_generator.h"

namespace nmc::test {

/// Five small streams that together use all that the format has.
inline std::vector<GeneratedStream> tiny_streams() {
  StreamRecipe closed;
  closed.name = "closed, two levels";
  closed.level_count = 2;

  StreamRecipe layered;
  layered.name = "sheet with creases, tangential parts and three quality layers";
  layered.base = grid(2, 2, false);
  layered.level_count = 2;
  layered.quality_layer_count = 3;
  layered.has_creases = true;
  layered.tangential_density = 0.2;
  layered.has_tensions = true;
  layered.largest_coefficient = 40;

  StreamRecipe handles;
  handles.name = "torus in few rows with ancillary chunks";
  handles.base = grid(3, 4, true);
  handles.level_count = 2;
  handles.has_ancillary_chunks = true;
  handles.one_layer_per_chunk = false;
  handles.seed = 5;

  StreamRecipe coloured;
  coloured.name = "disk with colours and another attribute";
  coloured.base = fan(5, true);
  coloured.level_count = 2;
  coloured.attribute_count = 2;
  coloured.seed = 3;

  StreamRecipe divided;
  divided.name = "sheet in three regions, two quality layers";
  divided.base = grid(3, 2, false);
  divided.level_count = 3;
  divided.quality_layer_count = 2;
  divided.region_count = 3;
  divided.tangential_density = 0.1;
  divided.has_creases = true;
  return {generate(closed), generate(layered), generate(handles), generate(coloured), generate(divided)};
}

}  // namespace nmc::test

#endif  // NMC_TESTS_MALFORMED_TINY_STREAMS_H_

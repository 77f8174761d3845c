// SPDX-License-Identifier: Apache-2.0
// The decoder's instance of the coefficient coder, in a file of its own: most of the time that decoding takes
// is spent here, so that this file alone is compiled for speed at any size.
#include "libnmc/common/coefficient_coder.h"
#include "libnmc/decode/range_decoder.h"

namespace nmc {

template Status CoefficientModel::code_level<RangeDecoder>(RangeDecoder& coder, Memory* memory, int level,
                                                           const LevelTopology* coarse,
                                                           const LevelTopology& topology,
                                                           const std::int32_t* vertex_values,
                                                           const LevelCoefficients* previous,
                                                           LevelCoefficients& coefficients,
                                                           const std::uint32_t* edge_number);

}  // namespace nmc

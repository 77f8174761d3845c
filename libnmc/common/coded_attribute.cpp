// SPDX-License-Identifier: Apache-2.0
#include "libnmc/common/coded_attribute.h"

#include "libnmc/common/hash.h"

namespace nmc {

Status CodedAttribute::begin_level(int level, const AttributeDescriptor& descriptor,
                                   std::size_t vertex_count) {
  NMC_CHECK_STREAM(level == next_level_ && level <= descriptor.finest_level, "10.3",
                   "a level of an attribute comes out of order");
  if (level == 0) {
    if (!model_.resize(1)) return no_memory();
    model_[0].reset();
  }
  const std::size_t needed = vertex_count * static_cast<std::size_t>(descriptor.component_count);
  if (values_.size() < needed && !values_.resize(needed)) return no_memory();
  return ok_status();
}

void CodedAttribute::end_level(int level) {
  next_level_ = known_levels_ = level + 1;
  deviations_.release();
}

Status CodedAttribute::predict_level(const AttributeDescriptor& descriptor, int level,
                                     const LevelTopology& coarse, StopRequest stop) {
  if (known_levels_ > level) return ok_status();
  if (known_levels_ < level)
    return NMC_ERROR(kState, nullptr, "a coarser level of the attribute is missing");
  const int count = descriptor.component_count;
  const std::size_t needed =
      (std::size_t{coarse.vertex_count} + coarse.edge_count) * static_cast<std::size_t>(count);
  if (values_.size() < needed && !values_.resize(needed)) return no_memory();
  const AttributeLevel midpoint;
  const AttributeLevel& parameters = level <= descriptor.finest_level ? descriptor.levels[level] : midpoint;
  Neighbourhood around;
  for (std::uint32_t edge = 0; edge < coarse.edge_count; ++edge) {
    if ((edge & 65535u) == 0) NMC_TRY(stop.check());
    interpolate(descriptor, parameters, coarse, edge, around);
    for (int c = 0; c < count; ++c) {
      values_[(std::size_t{coarse.vertex_count} + edge) * count + c] =
          static_cast<std::int16_t>(around.interpolation[c]);
    }
  }
  known_levels_ = level + 1;
  return ok_status();
}

std::uint64_t CodedAttribute::hash(const AttributeDescriptor& descriptor, std::uint32_t vertex_count) const {
  Hash64 hash;
  const std::size_t count = std::size_t{vertex_count} * static_cast<std::size_t>(descriptor.component_count);
  for (std::size_t i = 0; i < count; ++i) hash.add_i32(values_[i]);
  return hash.value();
}

}  // namespace nmc

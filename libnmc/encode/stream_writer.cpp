// SPDX-License-Identifier: Apache-2.0
#include "libnmc/encode/stream_writer.h"

#include "libnmc/common/checksum.h"
#include "libnmc/encode/base_face_lookup.h"
#include "libnmc/encode/byte_writer.h"
#include "libnmc/encode/range_encoder.h"

namespace nmc {

StreamWriter::StreamWriter(Header& header, Memory* memory)
    : memory_(memory), header_(header), mesh_(memory, &header), chunks_(memory) {}

Status StreamWriter::add_base(const std::uint32_t* face_vertices, const std::int32_t* coordinates,
                              const std::uint8_t* creases, Array<std::uint32_t>& old_index) {
  BaseFaceLookup lookup(memory_);
  NMC_TRY(lookup.build(face_vertices, header_.base_face_count, header_.base_vertex_count, memory_));
  std::uint32_t best_share = 0;
  double best_bits = 0;
  for (std::uint32_t share = 0; share < 8; ++share) {
    CodedMesh trial(memory_, &header_);
    trial.set_parallelogram_share(share);
    BitCounter counter;
    NMC_TRY(trial.code_base(counter, &lookup, lookup.seeds(), coordinates, creases, &old_index));
    if (share == 0 || counter.bits() < best_bits) {
      best_share = share;
      best_bits = counter.bits();
    }
  }
  mesh_.set_parallelogram_share(best_share);
  Array<std::uint8_t> payload(memory_);
  RangeEncoder coder(payload);
  NMC_TRY(mesh_.code_base(coder, &lookup, lookup.seeds(), coordinates, creases, &old_index));
  coder.finish();
  if (coder.out_of_memory()) return no_memory();
  return add_chunk(static_cast<std::uint8_t>(ChunkType::kBaseMesh), payload.data(), payload.size());
}

Status StreamWriter::add_base_correction(int layer, const std::int32_t* coordinates) {
  Array<std::uint8_t> payload(memory_);
  if (!payload.push_back(static_cast<std::uint8_t>(layer))) return no_memory();
  RangeEncoder coder(payload);
  NMC_TRY(mesh_.code_base_correction(coder, layer, coordinates));
  coder.finish();
  if (coder.out_of_memory()) return no_memory();
  return add_chunk(static_cast<std::uint8_t>(ChunkType::kBaseCorrection), payload.data(), payload.size());
}

Status StreamWriter::add_levels(int layer, int first_level, int level_count, const LevelCoefficients* const* levels) {
  Array<std::uint8_t> payload(memory_);
  if (!payload.push_back(static_cast<std::uint8_t>(layer)) ||
      !payload.push_back(static_cast<std::uint8_t>(first_level)) ||
      !payload.push_back(static_cast<std::uint8_t>(level_count))) {
    return no_memory();
  }
  RangeEncoder coder(payload);
  for (int i = 0; i < level_count; ++i) NMC_TRY(mesh_.code_level(coder, layer, first_level + i, levels[i]));
  coder.finish();
  if (coder.out_of_memory()) return no_memory();
  return add_chunk(static_cast<std::uint8_t>(ChunkType::kGeometry), payload.data(), payload.size());
}

Status StreamWriter::add_region(int layer, int region, const LevelCoefficients* const* levels) {
  Array<std::uint8_t> payload(memory_);
  ByteWriter(payload).write_varint(static_cast<std::uint64_t>(region * header_.quality_layer_count + layer));
  CodedMesh::RegionCoder coding(memory_);
  NMC_TRY(mesh_.begin_region(layer, region, coding));
  RangeEncoder coder(payload);
  for (int i = 0; i < header_.region_level_count; ++i) {
    std::uint64_t value_count = 0;
    NMC_TRY(mesh_.begin_region_level(header_.region_level + i, coding, value_count));
    NMC_TRY(mesh_.code_region_level(coder, coding, levels[i]));
  }
  mesh_.end_region(coding);
  coder.finish();
  if (coder.out_of_memory()) return no_memory();
  return add_chunk(static_cast<std::uint8_t>(ChunkType::kRegion), payload.data(), payload.size());
}

Status StreamWriter::add_attribute(int attribute, int first_level, int level_count,
                                   const std::int32_t* const* corrections) {
  Array<std::uint8_t> payload(memory_);
  if (!payload.push_back(static_cast<std::uint8_t>(attribute)) ||
      !payload.push_back(static_cast<std::uint8_t>(first_level)) ||
      !payload.push_back(static_cast<std::uint8_t>(level_count))) {
    return no_memory();
  }
  const auto component_count = static_cast<std::size_t>(header_.attributes[attribute].component_count);
  RangeEncoder coder(payload);
  for (int level = first_level; level < first_level + level_count; ++level) {
    const std::int32_t* next = corrections[level - first_level];
    NMC_TRY(mesh_.code_attribute(coder, attribute, level,
                                 [&](std::uint32_t, const std::int32_t*, const AttributeContexts&,
                                     AttributeModel&, std::int32_t* chosen) {
                                   for (std::size_t c = 0; c < component_count; ++c) chosen[c] = *next++;
                                 }));
  }
  coder.finish();
  if (coder.out_of_memory()) return no_memory();
  return add_chunk(static_cast<std::uint8_t>(ChunkType::kAttribute), payload.data(), payload.size());
}

Status StreamWriter::add_chunk(std::uint8_t type, const std::uint8_t* payload, std::size_t size) {
  const std::size_t start = chunks_.size();
  ByteWriter writer(chunks_);
  writer.write_u8(type);
  writer.write_varint(size);
  writer.write_bytes(payload, size);
  if (writer.out_of_memory()) return no_memory();
  writer.write_u32(crc32c(chunks_.data() + start, chunks_.size() - start));
  return writer.out_of_memory() ? no_memory() : ok_status();
}

Status StreamWriter::end_layer(int level, std::uint16_t rms_error, std::uint16_t max_error, int region) {
  LayerEntry entry{};
  entry.size = chunks_.size() - layer_start_;
  entry.level = static_cast<std::uint8_t>(level);
  entry.rms_error = rms_error;
  entry.max_error = max_error;
  entry.region = static_cast<std::uint8_t>(region + 1);
  layer_start_ = chunks_.size();
  return header_.layers.push_back(entry) ? ok_status() : no_memory();
}

Status StreamWriter::write_stream(Array<std::uint8_t>& bytes) const {
  NMC_TRY(write_header(header_, bytes));
  ByteWriter writer(bytes);
  writer.write_bytes(chunks_.data(), chunks_.size());
  return writer.out_of_memory() ? no_memory() : ok_status();
}

namespace {

void write_attribute(const AttributeDescriptor& attribute, ByteWriter& writer) {
  writer.write_u8(attribute.kind);
  writer.write_u8(static_cast<std::uint8_t>(attribute.component_count));
  writer.write_u8(static_cast<std::uint8_t>(attribute.bit_count));
  writer.write_u8(attribute.is_decorrelated ? 1 : 0);
  writer.write_u8(static_cast<std::uint8_t>(attribute.finest_level));
  for (int l = 0; l <= attribute.finest_level; ++l) {
    const AttributeLevel& level = attribute.levels[l];
    for (int c = 0; c < attribute.component_count; ++c) writer.write_u8(level.step[c]);
    if (l == 0) continue;
    writer.write_u8(static_cast<std::uint8_t>((level.opposite_share - kLowestOppositeShare) |
                                              (level.near_share << 4)));
  }
}

}  // namespace

Status write_header(const Header& header, Array<std::uint8_t>& bytes) {
  Array<std::uint8_t> fields;
  ByteWriter writer(fields);
  bool has_tensions = false;
  for (int l = 0; l < header.level_count; ++l) has_tensions |= header.tension_code[l] != 4;
  const bool has_layers = header.quality_layer_count > 1;
  writer.write_u8(static_cast<std::uint8_t>((header.has_creases ? 1 : 0) | (header.attribute_count > 0 ? 2 : 0) |
                                            (has_tensions ? 4 : 0) | (has_layers ? 8 : 0) |
                                            (header.region_count > 0 ? 16 : 0)));
  writer.write_u8(static_cast<std::uint8_t>(static_cast<int>(header.units) |
                                            (static_cast<int>(header.up_axis) << 4)));
  writer.write_varint(header.step_mantissa);
  writer.write_signed_varint(header.step_exponent);
  for (const std::int64_t o : header.origin) writer.write_signed_varint(o);
  for (const std::uint64_t e : header.extent) writer.write_varint(e);
  writer.write_varint(header.input_vertex_count);
  writer.write_varint(header.input_triangle_count);
  writer.write_varint(header.base_vertex_count);
  writer.write_varint(header.base_face_count);
  writer.write_u8(static_cast<std::uint8_t>(header.level_count));
  if (has_layers) {
    writer.write_u8(static_cast<std::uint8_t>(header.quality_layer_count));
    for (int k = 1; k < header.quality_layer_count; ++k) writer.write_u8(header.layer_ratio[k]);
  }
  if (header.region_count > 0) {
    writer.write_u8(static_cast<std::uint8_t>(header.region_count));
    writer.write_u8(static_cast<std::uint8_t>(header.region_level));
    writer.write_u8(static_cast<std::uint8_t>(header.region_level_count));
  }
  if (header.level_count > 0) writer.write_u8(header.tangential_code);
  for (int l = 0; l < header.level_count; ++l) writer.write_u8(header.step_code[l]);
  if (has_tensions) {
    for (int l = 0; l < header.level_count; ++l) writer.write_u8(header.tension_code[l]);
  }
  if (header.attribute_count > 0) {
    writer.write_u8(static_cast<std::uint8_t>(header.attribute_count));
    for (int i = 0; i < header.attribute_count; ++i) write_attribute(header.attributes[i], writer);
  }
  writer.write_varint(header.layers.size());
  for (const LayerEntry& entry : header.layers) {
    writer.write_varint(entry.size);
    writer.write_u8(entry.level);
    writer.write_u16(entry.rms_error);
    writer.write_u16(entry.max_error);
    if (header.region_count > 0) writer.write_u8(entry.region);
  }
  if (writer.out_of_memory()) return no_memory();

  bytes.clear();
  ByteWriter stream(bytes);
  stream.write_bytes(kSignature, 4);
  stream.write_u8(kFormatVersion);
  stream.write_varint(fields.size());
  stream.write_bytes(fields.data(), fields.size());
  if (stream.out_of_memory()) return no_memory();
  stream.write_u32(crc32c(bytes.data(), bytes.size()));
  return stream.out_of_memory() ? no_memory() : ok_status();
}

Status order_base_mesh(const std::uint32_t* face_vertices, std::uint32_t face_count, std::uint32_t vertex_count,
                       Memory* memory, Array<std::uint32_t>& old_index, Array<std::uint32_t>& new_faces) {
  BaseFaceLookup lookup(memory);
  NMC_TRY(lookup.build(face_vertices, face_count, vertex_count, memory));
  BaseMeshModel model;
  BitCounter counter;
  BaseMesh mesh(memory);
  mesh.vertex_count = vertex_count;
  mesh.face_count = face_count;
  NMC_TRY(model.code_connectivity(counter, memory, &lookup, lookup.seeds(), mesh, old_index));
  new_faces.swap(mesh.face_vertices);
  return ok_status();
}

}  // namespace nmc

// SPDX-License-Identifier: Apache-2.0
// The C API of nmc.h over StreamDecoder: arguments are checked here, streams below.
#include <cfloat>
#include <cstring>
#include <new>

#include "libnmc/common/hash.h"
#include "libnmc/decode/stream_decoder.h"
#include "libnmc/decode/vertex_normals.h"
#include "libnmc/include/nmc/nmc.h"

// The C API and the library below it number their statuses alike.
static_assert(NMC_OK == static_cast<int>(nmc::StatusCode::kOk));
static_assert(NMC_NEED_MORE_INPUT == static_cast<int>(nmc::StatusCode::kNeedMoreInput));
static_assert(NMC_ERR_NOT_NMC == static_cast<int>(nmc::StatusCode::kNotNmc));
static_assert(NMC_ERR_VERSION == static_cast<int>(nmc::StatusCode::kVersion));
static_assert(NMC_ERR_FEATURE == static_cast<int>(nmc::StatusCode::kFeature));
static_assert(NMC_ERR_CORRUPT == static_cast<int>(nmc::StatusCode::kCorrupt));
static_assert(NMC_ERR_CHECKSUM == static_cast<int>(nmc::StatusCode::kChecksum));
static_assert(NMC_ERR_TRUNCATED == static_cast<int>(nmc::StatusCode::kTruncated));
static_assert(NMC_ERR_LIMIT == static_cast<int>(nmc::StatusCode::kLimit));
static_assert(NMC_ERR_NO_MEMORY == static_cast<int>(nmc::StatusCode::kNoMemory));
static_assert(NMC_ERR_STOPPED == static_cast<int>(nmc::StatusCode::kStopped));
static_assert(NMC_ERR_ARGUMENT == static_cast<int>(nmc::StatusCode::kArgument));
static_assert(NMC_ERR_STATE == static_cast<int>(nmc::StatusCode::kState));
static_assert(NMC_UNITS_KILOMETRE == static_cast<int>(nmc::Units::kKilometre));
static_assert(NMC_UP_Z == static_cast<int>(nmc::UpAxis::kZ));

struct nmc_decoder {
  nmc_decoder(const nmc::Memory& used_memory, const nmc::DecoderLimits& used_limits)
      : memory(used_memory), limits(used_limits), stream(&memory, limits) {}

  nmc::Memory memory;
  nmc::DecoderLimits limits;
  nmc::StreamDecoder stream;
  mutable nmc::Status last_call;  // of the calls that have no error of the stream to report
  mutable nmc::StatusDetail caller_error{};
};

namespace {

nmc_status record(const nmc_decoder* decoder, nmc::Status status) {
  if (status.code() == nmc::StatusCode::kNoMemory && decoder->memory.limit_reached()) {
    status = NMC_ERROR(kLimit, "8", "the limit on memory is reached");
  }
  decoder->last_call = status;
  return static_cast<nmc_status>(status.code());
}

nmc_status argument_error(const nmc_decoder* decoder, const char* message) {
  decoder->caller_error = {nmc::StatusCode::kArgument, nullptr, message};
  return record(decoder, nmc::Status(&decoder->caller_error));
}

nmc_status state_error(const nmc_decoder* decoder, const char* message) {
  decoder->caller_error = {nmc::StatusCode::kState, nullptr, message};
  return record(decoder, nmc::Status(&decoder->caller_error));
}

constexpr const char* kNull = NMC_MESSAGE("a pointer is null");
constexpr const char* kNoHeader = NMC_MESSAGE("the header is not complete yet");
constexpr const char* kNoAttribute = NMC_MESSAGE("the stream has no such attribute");

/// The vertices of `level` are `vertex_count`, and `stride` can hold `value_count` values of `value_size`
/// bytes.
nmc_status check_output(const nmc_decoder* decoder, uint32_t level, const void* values,
                        std::size_t value_size, std::size_t value_count, std::size_t stride,
                        uint32_t vertex_count) {
  uint32_t expected = 0, unused = 0;
  const nmc_status status = nmc_decoder_mesh_size(decoder, level, &expected, &unused);
  if (status != NMC_OK) return status;
  if (!values) return argument_error(decoder, kNull);
  if (vertex_count != expected) return argument_error(decoder, NMC_MESSAGE("the vertex count is not that of the level"));
  if (stride < value_count * value_size || stride % value_size != 0) {
    return argument_error(decoder, NMC_MESSAGE("the stride cannot hold the values of a vertex"));
  }
  return NMC_OK;
}

/// Finite in single precision too.
float to_float(double value) {
  constexpr double kLargest = FLT_MAX;
  return static_cast<float>(value > kLargest ? kLargest : value < -kLargest ? -kLargest : value);
}

inline void convert(double value, float& output) { output = to_float(value); }
inline void convert(double value, double& output) { output = value; }

template <class Value>
void write_positions(const nmc::Vec3* positions, uint32_t vertex_count, Value* output, std::size_t stride) {
  const std::size_t step = stride / sizeof(Value);
  for (std::size_t v = 0; v < vertex_count; ++v, output += step) {
    convert(positions[v].x, output[0]);
    convert(positions[v].y, output[1]);
    convert(positions[v].z, output[2]);
  }
}

/// Components of the attribute as the user knows them: red, green and blue from luma and chroma. A fourth one
/// that the attribute does not have is its largest value. `scaled_from_bits` above 0: values are brought to
/// eight bits.
template <class Value>
void write_attribute(const nmc::AttributeDescriptor& descriptor, const std::int16_t* coded, uint32_t count,
                     uint32_t vertex_count, Value* output, std::size_t stride, int scaled_from_bits) {
  const std::size_t step = stride / sizeof(Value);
  const std::int32_t largest = descriptor.largest_value();
  const auto own_count = static_cast<uint32_t>(descriptor.component_count);
  for (std::size_t v = 0; v < vertex_count; ++v) {
    std::int32_t own[4] = {largest, largest, largest, largest};
    for (uint32_t c = 0; c < own_count; ++c) own[c] = coded[v * own_count + c];
    if (descriptor.is_decorrelated) {
      const std::int32_t luma_chroma[3] = {own[0], own[1], own[2]};
      nmc::rgb_from_luma_chroma(luma_chroma, largest, own);
    }
    for (uint32_t c = 0; c < count; ++c) {
      const std::int32_t value = scaled_from_bits > 0 && scaled_from_bits != 8
                                     ? (2 * 255 * own[c] + largest) / (2 * largest)
                                     : own[c];
      output[v * step + c] = static_cast<Value>(value);
    }
  }
}

template <class Value>
nmc_status read_positions(nmc_decoder* decoder, uint32_t level, Value* positions, std::size_t stride,
                          uint32_t vertex_count) {
  if (!decoder) return NMC_ERR_ARGUMENT;
  const nmc_status checked = check_output(decoder, level, positions, sizeof(Value), 3, stride, vertex_count);
  if (checked != NMC_OK) return checked;
  const nmc::Status updated = decoder->stream.update_positions(static_cast<int>(level));
  if (!updated.ok()) return record(decoder, updated);
  write_positions(decoder->stream.mesh().positions(), vertex_count, positions, stride);
  return NMC_OK;
}

}  // namespace

extern "C" {

const char* nmc_status_name(nmc_status status) {
  switch (status) {
    case NMC_OK:
      return "NMC_OK";
    case NMC_NEED_MORE_INPUT:
      return "NMC_NEED_MORE_INPUT";
    case NMC_ERR_NOT_NMC:
      return "NMC_ERR_NOT_NMC";
    case NMC_ERR_VERSION:
      return "NMC_ERR_VERSION";
    case NMC_ERR_FEATURE:
      return "NMC_ERR_FEATURE";
    case NMC_ERR_CORRUPT:
      return "NMC_ERR_CORRUPT";
    case NMC_ERR_CHECKSUM:
      return "NMC_ERR_CHECKSUM";
    case NMC_ERR_TRUNCATED:
      return "NMC_ERR_TRUNCATED";
    case NMC_ERR_LIMIT:
      return "NMC_ERR_LIMIT";
    case NMC_ERR_NO_MEMORY:
      return "NMC_ERR_NO_MEMORY";
    case NMC_ERR_STOPPED:
      return "NMC_ERR_STOPPED";
    case NMC_ERR_ARGUMENT:
      return "NMC_ERR_ARGUMENT";
    case NMC_ERR_STATE:
      return "NMC_ERR_STATE";
  }
  return "NMC_UNKNOWN";
}

uint32_t nmc_version(void) { return NMC_VERSION; }

uint32_t nmc_format_version(void) { return nmc::kFormatVersion; }

nmc_limits nmc_default_limits(void) {
  const nmc::DecoderLimits defaults;
  nmc_limits limits;
  limits.struct_size = sizeof limits;
  limits.max_memory = sizeof(size_t) > 4 ? uint64_t{4} << 30 : uint64_t{1} << 30;
  limits.max_vertices = defaults.maximum_vertices;
  limits.max_base_vertices = defaults.maximum_base_vertices;
  limits.max_levels = defaults.maximum_levels;
  limits.max_chunk_size = defaults.maximum_chunk_size;
  limits.should_stop = nullptr;
  limits.should_stop_user = nullptr;
  return limits;
}

nmc_status nmc_decoder_create(nmc_decoder** decoder, const nmc_limits* limits,
                              const nmc_allocator* allocator) {
  if (!decoder) return NMC_ERR_ARGUMENT;
  *decoder = nullptr;
  nmc_limits used = nmc_default_limits();
  if (limits) {
    // A later version may have more fields; a caller built for an older one leaves the rest at the defaults.
    if (limits->struct_size < offsetof(nmc_limits, max_vertices) || limits->struct_size > 4096) {
      return NMC_ERR_ARGUMENT;
    }
    const size_t known = limits->struct_size < sizeof used ? limits->struct_size : sizeof used;
    std::memcpy(&used, limits, known);
  }
  if (allocator && (!allocator->allocate || !allocator->release)) return NMC_ERR_ARGUMENT;
  nmc::Memory memory =
      allocator ? nmc::Memory(allocator->allocate, allocator->release, allocator->user, used.max_memory)
                : nmc::Memory(nullptr, nullptr, nullptr, used.max_memory);
  void* place = memory.allocate(sizeof(nmc_decoder));
  if (!place) return memory.limit_reached() ? NMC_ERR_LIMIT : NMC_ERR_NO_MEMORY;
  nmc::DecoderLimits stream_limits;
  stream_limits.maximum_base_vertices = used.max_base_vertices;
  stream_limits.maximum_vertices = used.max_vertices;
  stream_limits.maximum_levels = used.max_levels;
  stream_limits.maximum_chunk_size = used.max_chunk_size;
  stream_limits.stop = {used.should_stop, used.should_stop_user};
  *decoder = new (place) nmc_decoder(memory, stream_limits);
  return NMC_OK;
}

void nmc_decoder_destroy(nmc_decoder** decoder) {
  if (!decoder || !*decoder) return;
  (*decoder)->stream.~StreamDecoder();
  // The arrays have given their memory back through the decoder's own Memory; its last block is the decoder
  // itself.
  nmc::Memory memory = (*decoder)->memory;
  memory.release(*decoder, sizeof(nmc_decoder));
  *decoder = nullptr;
}

nmc_status nmc_decoder_reset(nmc_decoder* decoder) {
  if (!decoder) return NMC_ERR_ARGUMENT;
  decoder->stream.~StreamDecoder();
  decoder->memory.forget_limit_reached();
  new (&decoder->stream) nmc::StreamDecoder(&decoder->memory, decoder->limits);
  decoder->last_call = {};
  return NMC_OK;
}

nmc_status nmc_decoder_set_threads(nmc_decoder* decoder, nmc_run_tasks run_tasks, void* user) {
  if (!decoder) return NMC_ERR_ARGUMENT;
  decoder->limits.runner = {run_tasks, user};
  decoder->stream.set_task_runner(decoder->limits.runner);
  return NMC_OK;
}

nmc_status nmc_decoder_feed(nmc_decoder* decoder, const void* data, size_t size) {
  if (!decoder) return NMC_ERR_ARGUMENT;
  if (!data && size > 0) return argument_error(decoder, kNull);
  return record(decoder, decoder->stream.feed(static_cast<const uint8_t*>(data), size));
}

nmc_status nmc_decoder_next(nmc_decoder* decoder, nmc_event* event) {
  if (!decoder) return NMC_ERR_ARGUMENT;
  if (!event) return argument_error(decoder, kNull);
  nmc::DecoderEvent found;
  const nmc::Status status = decoder->stream.next(found);
  if (!status.ok()) return record(decoder, status);
  switch (found) {
    case nmc::DecoderEvent::kNeedMoreInput:
      return NMC_NEED_MORE_INPUT;
    case nmc::DecoderEvent::kHeader:
      *event = NMC_EVENT_HEADER;
      break;
    case nmc::DecoderEvent::kLayer:
      *event = NMC_EVENT_LAYER;
      break;
    case nmc::DecoderEvent::kEnd:
      *event = NMC_EVENT_END;
      break;
  }
  return NMC_OK;
}

nmc_status nmc_decoder_finish(nmc_decoder* decoder) {
  if (!decoder) return NMC_ERR_ARGUMENT;
  return record(decoder, decoder->stream.finish());
}

nmc_status nmc_decoder_error(const nmc_decoder* decoder, nmc_error_detail* detail) {
  if (!decoder || !detail) return NMC_ERR_ARGUMENT;
  const nmc::DecoderError& error = decoder->stream.error();
  const bool is_of_stream = !error.status.ok();
  const nmc::Status& status = is_of_stream ? error.status : decoder->last_call;
  detail->status = static_cast<nmc_status>(status.code());
  detail->byte_offset = is_of_stream ? error.byte_offset : 0;
  detail->chunk_type = is_of_stream ? error.chunk_type : 0;
  detail->spec_section = status.section() ? status.section() : "";
  detail->message = status.message() ? status.message() : "";
  return NMC_OK;
}

nmc_status nmc_decoder_info(const nmc_decoder* decoder, nmc_info* info) {
  if (!decoder) return NMC_ERR_ARGUMENT;
  if (!info) return argument_error(decoder, kNull);
  if (!decoder->stream.has_header()) return state_error(decoder, kNoHeader);
  const nmc::Header& header = decoder->stream.header();
  info->header_size = decoder->stream.header_size();
  info->stream_size = info->header_size;
  for (const nmc::LayerEntry& entry : header.layers) info->stream_size += entry.size;
  info->layer_count = static_cast<uint32_t>(header.layers.size());
  info->level_count = static_cast<uint32_t>(header.level_count);
  info->quality_layer_count = static_cast<uint32_t>(header.quality_layer_count);
  info->base_vertex_count = header.base_vertex_count;
  info->base_face_count = header.base_face_count;
  info->input_vertex_count = header.input_vertex_count;
  info->input_triangle_count = header.input_triangle_count;
  info->grid_step = header.grid_step();
  for (int k = 0; k < 3; ++k) {
    const double low = static_cast<double>(header.origin[k]), size = static_cast<double>(header.extent[k]);
    info->box_min[k] = low * info->grid_step;
    info->box_max[k] = (low + size) * info->grid_step;
  }
  info->diagonal = header.diagonal();
  info->units = static_cast<nmc_units>(header.units);
  info->up_axis = static_cast<nmc_up_axis>(header.up_axis);
  info->has_creases = header.has_creases ? 1 : 0;
  info->has_colors = header.color_attribute() >= 0 ? 1 : 0;
  info->region_count = header.region_count;
  return NMC_OK;
}

nmc_status nmc_decoder_skip_layer(nmc_decoder* decoder) {
  return decoder ? record(decoder, decoder->stream.skip_row()) : NMC_ERR_ARGUMENT;
}

nmc_status nmc_decoder_read_regions(nmc_decoder* decoder, uint8_t* regions, uint32_t face_count) {
  if (!decoder) return NMC_ERR_ARGUMENT;
  if (!regions || face_count != decoder->stream.header().base_face_count)
    return argument_error(decoder, NMC_MESSAGE("the face count is not that of the base mesh"));
  return record(decoder, decoder->stream.read_regions(regions));
}

nmc_status nmc_decoder_layer(const nmc_decoder* decoder, uint32_t index, nmc_layer* layer) {
  if (!decoder) return NMC_ERR_ARGUMENT;
  if (!layer) return argument_error(decoder, kNull);
  if (!decoder->stream.has_header()) return state_error(decoder, kNoHeader);
  const nmc::Header& header = decoder->stream.header();
  if (index >= header.layers.size()) return argument_error(decoder, NMC_MESSAGE("the table has no such layer"));
  layer->index = index;
  layer->end_offset = decoder->stream.header_size();
  for (uint32_t i = 0; i <= index; ++i) layer->end_offset += header.layers[i].size;
  const nmc::LayerEntry& entry = header.layers[index];
  layer->level = entry.level;
  layer->face_count = uint64_t{header.base_face_count} << (2 * entry.level);
  layer->has_error = entry.max_error != nmc::kUnknownError;
  layer->region = static_cast<int32_t>(entry.region) - 1;
  const double diagonal = header.diagonal();
  layer->rms_error = nmc::error_from_code(entry.rms_error, diagonal);
  layer->max_error = nmc::error_from_code(entry.max_error, diagonal);
  return NMC_OK;
}

nmc_status nmc_decoder_current_layer(const nmc_decoder* decoder, nmc_layer* layer) {
  if (!decoder) return NMC_ERR_ARGUMENT;
  const std::size_t complete = decoder->stream.layers_complete();
  if (complete == 0) return state_error(decoder, NMC_MESSAGE("no layer is complete yet"));
  return nmc_decoder_layer(decoder, static_cast<uint32_t>(complete - 1), layer);
}

nmc_status nmc_decoder_select_layer(const nmc_decoder* decoder, nmc_criterion criterion, double value,
                                    uint32_t* index, int* is_met) {
  if (!decoder) return NMC_ERR_ARGUMENT;
  if (!index) return argument_error(decoder, kNull);
  if (!decoder->stream.has_header()) return state_error(decoder, kNoHeader);
  if (criterion < NMC_BY_MAX_ERROR || criterion > NMC_BY_LEVEL) {
    return argument_error(decoder, NMC_MESSAGE("there is no such criterion"));
  }
  const bool wants_first = criterion == NMC_BY_MAX_ERROR || criterion == NMC_BY_RMS_ERROR;
  const auto layer_count = static_cast<uint32_t>(decoder->stream.header().layers.size());
  uint32_t found = wants_first ? layer_count - 1 : 0;
  int met = 0;
  for (uint32_t i = 0; i < layer_count && !(wants_first && met); ++i) {
    nmc_layer layer;
    const nmc_status status = nmc_decoder_layer(decoder, i, &layer);
    if (status != NMC_OK) return status;
    bool fits = false;
    switch (criterion) {
      case NMC_BY_MAX_ERROR:
        fits = layer.has_error && layer.max_error <= value;
        break;
      case NMC_BY_RMS_ERROR:
        fits = layer.has_error && layer.rms_error <= value;
        break;
      case NMC_BY_FACES:
        fits = static_cast<double>(layer.face_count) <= value;
        break;
      case NMC_BY_BYTES:
        fits = static_cast<double>(layer.end_offset) <= value;
        break;
      case NMC_BY_LEVEL:
        fits = layer.level <= value;
        break;
    }
    if (fits) {
      found = i;
      met = 1;
    }
  }
  *index = found;
  if (is_met) *is_met = met;
  return NMC_OK;
}

nmc_status nmc_decoder_mesh_size(const nmc_decoder* decoder, uint32_t level, uint32_t* vertex_count,
                                 uint32_t* face_count) {
  if (!decoder) return NMC_ERR_ARGUMENT;
  if (!vertex_count || !face_count) return argument_error(decoder, kNull);
  const int checked = level <= static_cast<uint32_t>(nmc::kMaximumLevelCount) ? static_cast<int>(level) : -1;
  return record(decoder, decoder->stream.level_size(checked, *vertex_count, *face_count));
}

nmc_status nmc_decoder_read_indices(nmc_decoder* decoder, uint32_t level, uint32_t* indices,
                                    size_t index_count) {
  if (!decoder) return NMC_ERR_ARGUMENT;
  uint32_t vertex_count = 0, face_count = 0;
  const nmc_status status = nmc_decoder_mesh_size(decoder, level, &vertex_count, &face_count);
  if (status != NMC_OK) return status;
  if (!indices) return argument_error(decoder, kNull);
  if (index_count != uint64_t{3} * face_count) {
    return argument_error(decoder, NMC_MESSAGE("the index count is not three times the face count of the level"));
  }
  return record(decoder, decoder->stream.read_indices(static_cast<int>(level), indices));
}

nmc_status nmc_decoder_read_positions(nmc_decoder* decoder, uint32_t level, float* positions, size_t stride,
                                      uint32_t vertex_count) {
  return read_positions(decoder, level, positions, stride, vertex_count);
}

nmc_status nmc_decoder_read_positions_double(nmc_decoder* decoder, uint32_t level, double* positions,
                                             size_t stride, uint32_t vertex_count) {
  return read_positions(decoder, level, positions, stride, vertex_count);
}

nmc_status nmc_decoder_read_normals(nmc_decoder* decoder, uint32_t level, float* normals, size_t stride,
                                    uint32_t vertex_count) {
  if (!decoder) return NMC_ERR_ARGUMENT;
  const nmc_status checked = check_output(decoder, level, normals, sizeof(float), 3, stride, vertex_count);
  if (checked != NMC_OK) return checked;
  const nmc::Status updated = decoder->stream.update_positions(static_cast<int>(level));
  if (!updated.ok()) return record(decoder, updated);
  const nmc::CodedMesh& mesh = decoder->stream.mesh();
  nmc::write_vertex_normals(mesh.topology(level == 0 ? 0 : static_cast<int>(level) - 1), level > 0,
                            mesh.positions(), vertex_count, reinterpret_cast<unsigned char*>(normals),
                            stride);
  return NMC_OK;
}

nmc_status nmc_decoder_read_offsets(nmc_decoder* decoder, uint32_t level, float* normal_offsets,
                                    uint8_t* is_off_normal, uint32_t vertex_count) {
  if (!decoder) return NMC_ERR_ARGUMENT;
  uint32_t expected = 0, unused = 0;
  const nmc_status sized = nmc_decoder_mesh_size(decoder, level, &expected, &unused);
  if (sized != NMC_OK) return sized;
  if (vertex_count != expected) {
    return argument_error(decoder, NMC_MESSAGE("the vertex count is not that of the level"));
  }
  if (normal_offsets) std::memset(normal_offsets, 0, sizeof(float) * vertex_count);
  if (is_off_normal) std::memset(is_off_normal, 0, vertex_count);
  const nmc::CodedMesh& mesh = decoder->stream.mesh();
  for (uint32_t l = 0; l < level; ++l) {
    if (mesh.layer_of_level(static_cast<int>(l)) < 0) break;
    const nmc::LevelCoefficients& coefficients = mesh.coefficients(static_cast<int>(l));
    const double step = mesh.current_quantizer(static_cast<int>(l)).normal_step;
    // The odd vertex of edge e of a level is vertex V + e of the next one, so both arrays are filled in
    // order.
    const std::size_t first = mesh.topology(static_cast<int>(l)).vertex_count;
    const std::size_t room = vertex_count > first ? vertex_count - first : 0;
    for (std::size_t e = 0; normal_offsets && e < coefficients.normal.size() && e < room; ++e) {
      normal_offsets[first + e] = to_float(step * coefficients.normal[e]);
    }
    for (std::size_t i = 0; is_off_normal && i < coefficients.tangential.size(); ++i) {
      if (coefficients.tangential[i].edge < room) is_off_normal[first + coefficients.tangential[i].edge] = 1;
    }
  }
  return NMC_OK;
}

nmc_status nmc_decoder_state_hash(const nmc_decoder* decoder, uint64_t* hash) {
  if (!decoder) return NMC_ERR_ARGUMENT;
  if (!hash) return argument_error(decoder, kNull);
  uint32_t vertex_count = 0, face_count = 0;
  const nmc_status readable = nmc_decoder_mesh_size(decoder, 0, &vertex_count, &face_count);
  if (readable != NMC_OK) return readable;
  *hash = decoder->stream.mesh().state_hash();
  return NMC_OK;
}

nmc_status nmc_decoder_position_hash(nmc_decoder* decoder, uint32_t level, uint64_t* hash) {
  if (!decoder) return NMC_ERR_ARGUMENT;
  if (!hash) return argument_error(decoder, kNull);
  uint32_t vertex_count = 0, face_count = 0;
  const nmc_status readable = nmc_decoder_mesh_size(decoder, level, &vertex_count, &face_count);
  if (readable != NMC_OK) return readable;
  const nmc::Status updated = decoder->stream.update_positions(static_cast<int>(level));
  if (!updated.ok()) return record(decoder, updated);
  *hash = decoder->stream.mesh().position_hash(static_cast<int>(level));
  return NMC_OK;
}

nmc_status nmc_decoder_attribute(const nmc_decoder* decoder, uint32_t index, nmc_attribute* attribute) {
  if (!decoder) return NMC_ERR_ARGUMENT;
  if (!attribute) return argument_error(decoder, kNull);
  if (!decoder->stream.has_header()) return state_error(decoder, kNoHeader);
  const nmc::Header& header = decoder->stream.header();
  if (index >= static_cast<uint32_t>(header.attribute_count)) return argument_error(decoder, kNoAttribute);
  const nmc::AttributeDescriptor& descriptor = header.attributes[index];
  attribute->index = index;
  attribute->kind = descriptor.kind;
  attribute->component_count = static_cast<uint32_t>(descriptor.component_count);
  attribute->bit_count = static_cast<uint32_t>(descriptor.bit_count);
  attribute->finest_level = static_cast<uint32_t>(descriptor.finest_level);
  attribute->byte_count = decoder->stream.attribute_size(static_cast<int>(index));
  attribute->levels_complete =
      static_cast<uint32_t>(decoder->stream.mesh().attribute(static_cast<int>(index)).next_level());
  return NMC_OK;
}

nmc_status nmc_decoder_read_attribute(nmc_decoder* decoder, uint32_t index, uint32_t level, uint16_t* values,
                                      size_t stride, uint32_t vertex_count) {
  nmc_attribute attribute;
  const nmc_status known = nmc_decoder_attribute(decoder, index, &attribute);
  if (known != NMC_OK) return known;
  const nmc_status checked =
      check_output(decoder, level, values, sizeof(uint16_t), attribute.component_count, stride, vertex_count);
  if (checked != NMC_OK) return checked;
  const int number = static_cast<int>(index);
  const nmc::Status updated = decoder->stream.update_attribute(number, static_cast<int>(level));
  if (!updated.ok()) return record(decoder, updated);
  write_attribute(decoder->stream.header().attributes[index],
                  decoder->stream.mesh().attribute(number).values(), attribute.component_count, vertex_count,
                  values, stride, 0);
  return NMC_OK;
}

nmc_status nmc_decoder_read_colors(nmc_decoder* decoder, uint32_t level, uint8_t* colors,
                                   uint32_t component_count, size_t stride, uint32_t vertex_count) {
  if (!decoder) return NMC_ERR_ARGUMENT;
  if (component_count != 3 && component_count != 4) {
    return argument_error(decoder, NMC_MESSAGE("a colour has three or four components"));
  }
  const nmc_status checked =
      check_output(decoder, level, colors, sizeof(uint8_t), component_count, stride, vertex_count);
  if (checked != NMC_OK) return checked;
  const int index = decoder->stream.header().color_attribute();
  if (index < 0) return state_error(decoder, NMC_MESSAGE("the stream has no colours"));
  const nmc::Status updated = decoder->stream.update_attribute(index, static_cast<int>(level));
  if (!updated.ok()) return record(decoder, updated);
  const nmc::AttributeDescriptor& descriptor = decoder->stream.header().attributes[index];
  write_attribute(descriptor, decoder->stream.mesh().attribute(index).values(), component_count, vertex_count,
                  colors, stride, descriptor.bit_count);
  return NMC_OK;
}

nmc_status nmc_decoder_attribute_hash(nmc_decoder* decoder, uint32_t index, uint32_t level, uint64_t* hash) {
  if (!decoder) return NMC_ERR_ARGUMENT;
  if (!hash) return argument_error(decoder, kNull);
  uint32_t vertex_count = 0, face_count = 0;
  const nmc_status readable = nmc_decoder_mesh_size(decoder, level, &vertex_count, &face_count);
  if (readable != NMC_OK) return readable;
  if (index >= static_cast<uint32_t>(decoder->stream.header().attribute_count)) {
    return argument_error(decoder, kNoAttribute);
  }
  const int number = static_cast<int>(index);
  const nmc::Status updated = decoder->stream.update_attribute(number, static_cast<int>(level));
  if (!updated.ok()) return record(decoder, updated);
  *hash =
      decoder->stream.mesh().attribute(number).hash(decoder->stream.header().attributes[index], vertex_count);
  return NMC_OK;
}

nmc_status nmc_decoder_memory(const nmc_decoder* decoder, uint64_t* used, uint64_t* peak) {
  if (!decoder) return NMC_ERR_ARGUMENT;
  if (used) *used = decoder->memory.used();
  if (peak) *peak = decoder->memory.peak();
  return NMC_OK;
}

}  // extern "C"

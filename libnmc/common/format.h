// SPDX-License-Identifier: Apache-2.0
// Constants and header of the format: one entry per row of a table in format-spec.md, with the same names.
#ifndef NMC_COMMON_FORMAT_H_
#define NMC_COMMON_FORMAT_H_

#include <cstdint>

#include "libnmc/common/attribute.h"
#include "libnmc/common/memory.h"
#include "libnmc/common/reconstruct.h"

namespace nmc {

// spec 3.1
inline constexpr std::uint8_t kSignature[4] = {0x8e, 'N', 'M', 'C'};
inline constexpr std::uint8_t kFormatVersion = 1;

// spec 8
inline constexpr std::uint32_t kMaximumHeaderSize = 1 << 16;
inline constexpr std::uint32_t kMaximumChunkSize = 1 << 30;
inline constexpr int kMaximumLevelCount = 14;
inline constexpr int kMaximumLayerCount = 16;
inline constexpr std::uint32_t kMaximumTableSize = 1024;
inline constexpr std::uint32_t kMaximumRegionCount = 64;
inline constexpr std::uint64_t kVerticesPerByte = 64;      // a level may hold kFreeVertices + 64 vertices per
inline constexpr std::uint64_t kFreeVertices = 2048;       // byte of the stream up to the end of its chunk
inline constexpr std::uint64_t kBaseFacesPerByte = 64;     // the base mesh may hold kFreeBaseFaces + 64 faces per
inline constexpr std::uint64_t kFreeBaseFaces = 1024;      // byte of its chunk
inline constexpr std::uint64_t kValuesPerByte = 64;        // all layers together may hold kFreeValues + 64
inline constexpr std::uint64_t kFreeValues = 1 << 15;      // values per byte
inline constexpr std::uint64_t kMaximumVertexCount = std::uint64_t{1} << 30;
inline constexpr std::int64_t kMaximumOrigin = std::int64_t{1} << 51;

// spec 3.2: types of chunks. Those with the top bit set are ancillary: a decoder that does not know one skips it.
enum class ChunkType : std::uint8_t {
  kBaseMesh = 0x01,
  kBaseCorrection = 0x02,
  kGeometry = 0x03,
  kAttribute = 0x04,
  kRegion = 0x05,
  kMetadata = 0x81,
};
inline constexpr std::uint8_t kAncillaryBit = 0x80;

// spec 3.3.2
enum class Units : std::uint8_t { kUnknown, kMillimetre, kCentimetre, kMetre, kInch, kFoot, kKilometre };
enum class UpAxis : std::uint8_t { kUnknown, kY, kZ };

/// One row of the layer table: the state after the stream's first `end_offset` bytes (spec 3.3.5).
struct LayerEntry {
  std::uint64_t size;         // bytes since the row before; of the first row: since the end of the header
  std::uint8_t level;         // the level to show
  std::uint16_t rms_error;    // measured, as code: diagonal * 2^(-code / 2048)
  std::uint16_t max_error;
  std::uint8_t region;        // 0: chunks for all; r + 1: chunks of region r alone
};

/// Everything a viewer wants to know before it decodes (spec 3.3).
struct Header {
  explicit Header(Memory* memory = nullptr) : layers(memory) {}

  Units units = Units::kUnknown;
  UpAxis up_axis = UpAxis::kUnknown;
  bool has_creases = false;
  std::uint32_t step_mantissa = 1;   // grid step = mantissa * 2^exponent, mantissa < 2^24
  int step_exponent = 0;             // in [-160, 100]
  std::int64_t origin[3] = {0, 0, 0};      // of the box of the input, in grid steps
  std::uint64_t extent[3] = {0, 0, 0};     // size of the box, in grid steps
  std::uint64_t input_vertex_count = 0;
  std::uint64_t input_triangle_count = 0;
  std::uint32_t base_vertex_count = 0;
  std::uint32_t base_face_count = 0;
  int level_count = 0;               // finest level of the stream
  int quality_layer_count = 1;       // quality layers
  std::uint32_t region_count = 0;    // 0: the surface is not divided (spec 5.4)
  int region_level = 0;              // the first level that is, >= 1
  int region_level_count = 0;        // and how many are; beyond them there are no coefficients
  std::uint8_t layer_ratio[kMaximumLayerCount] = {};   // [k]: step of layer k-1 over step of layer k
  std::uint8_t step_code[kMaximumLevelCount] = {};     // per level: normal step of the last quality layer
  std::uint8_t tension_code[kMaximumLevelCount] = {};  // per level, in quarters
  std::uint8_t tangential_code = 0;  // tangential step over normal step
  int attribute_count = 0;
  AttributeDescriptor attributes[kMaximumAttributeCount];
  Array<LayerEntry> layers;

  double grid_step() const;
  /// Length of the diagonal of the box, in model units.
  double diagonal() const;
  /// Steps of a level (odd vertices of level `level`) in quality layer `layer` (spec 3.3.4).
  LevelQuantizer quantizer(int level, int layer) const;
  /// The first attribute that is a colour; -1: none.
  int color_attribute() const;
  /// Product of the ratios of the layers after `layer`.
  std::uint32_t ratio_after(int layer) const;
};

/// grid step * 2^((code - 64) / 8), from a table of the eighth roots of two: no library function (spec 3.3.4).
double step_from_code(double grid_step, std::uint8_t code);

/// Error codes of the layer table. Encoding rounds up: the stated error is never below the measured one.
/// kUnknownError stands for an error that was not measured, and decodes to 0.
inline constexpr std::uint16_t kUnknownError = 65535;
std::uint16_t error_to_code(double error, double diagonal);
double error_from_code(std::uint16_t code, double diagonal);

}  // namespace nmc

#endif  // NMC_COMMON_FORMAT_H_

// SPDX-License-Identifier: Apache-2.0
// A second decoder, for reading and for comparison: format-spec.md as a program, section by section, with
// nothing of libnmc in it. It decodes whole streams, slowly, and checks every rule of the format.
#ifndef NMC_DECODER_REFERENCE_REFERENCE_DECODER_H_
#define NMC_DECODER_REFERENCE_REFERENCE_DECODER_H_

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace nmc_reference {

/// The codes of spec 1.3.
enum class Code : int {
  kOk = 0,
  kNotNmc = -10,
  kVersion = -12,
  kFeature = -14,
  kCorrupt = -20,
  kChecksum = -22,
  kTruncated = -24,
  kLimit = -30,
};
/// "CORRUPT" and so on.
const char* name_of(Code code);

/// What a decoder may set below the limits of the format (spec 8). The defaults are those of nmc.h.
struct Limits {
  std::uint64_t base_vertices = 1u << 20;
  std::uint64_t vertices = 100'000'000;
  std::uint64_t levels = 14;
  std::uint64_t chunk_size = 1u << 30;
};

/// The mesh after one row of the layer table, as hashes (spec 9). A level that 8.2 or the limits forbid to
/// show has position hash and index hash 0.
struct Row {
  std::uint64_t end_offset = 0;
  std::uint32_t level = 0;
  std::uint64_t state_hash = 0;
  std::uint64_t position_hash = 0;
  std::uint64_t index_hash = 0;  // the hash of 9.3 over three vertices per face
  std::vector<std::uint64_t> attribute_hashes = {};  // 9.4; 0 for attributes that have not come
};

struct Decoding {
  Code code = Code::kOk;
  std::uint64_t offset = 0;
  std::string section;
  std::vector<Row> rows;
};

/// Decodes as many rows as the bytes hold. Never throws but for want of memory.
Decoding decode(const std::vector<std::uint8_t>& bytes, const Limits& limits = {});

/// The building blocks that the specification has examples of.
std::uint32_t crc32c(const std::uint8_t* data, std::size_t size);                // 2.3
bool read_varint(const std::vector<std::uint8_t>& bytes, std::uint64_t& value);  // 2.2; false: misspelt
double step_of_code(double step, int code);                                      // 3.3.4
std::vector<int> decisions(const std::vector<std::uint8_t>& payload,
                           const std::vector<std::uint32_t>& probabilities);
int energy_class(std::int64_t sixteenths);                       // 5.3.1
int squash(int x);                                               // B.1
int stretch(int p);                                              // B.2
double cosine(std::uint32_t i, std::uint32_t n);                 // A.7
std::uint64_t hash_of(const std::vector<std::uint32_t>& words);  // 9.3

}  // namespace nmc_reference

#endif  // NMC_DECODER_REFERENCE_REFERENCE_DECODER_H_

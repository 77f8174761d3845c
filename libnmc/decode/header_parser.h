// SPDX-License-Identifier: Apache-2.0
// The header of a stream (spec 3.3).
#ifndef NMC_DECODE_HEADER_PARSER_H_
#define NMC_DECODE_HEADER_PARSER_H_

#include <cstddef>
#include <cstdint>

#include "libnmc/common/format.h"
#include "libnmc/common/status.h"

namespace nmc {

/// How many bytes signature, version, header and its checksum take in all: kNeedMoreInput until `size` bytes
/// tell, else `total_size` is set. Fails on a wrong signature, version or size as soon as the bytes at hand
/// show it.
Status measure_header(const std::uint8_t* data, std::size_t size, std::size_t& total_size);

/// Parses `total_size` bytes as measured. Every field is checked against its range.
Status parse_header(const std::uint8_t* data, std::size_t total_size, Header& header);

}  // namespace nmc

#endif  // NMC_DECODE_HEADER_PARSER_H_

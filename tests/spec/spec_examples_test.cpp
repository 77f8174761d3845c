// SPDX-License-Identifier: Apache-2.0
// Every example of format-spec.md, run through the library and through the reference decoder.
#include <catch2/catch.hpp>
#include <cstdio>
#include <functional>
#include <map>

#include "decoder/reference/reference_decoder.h"
#include "libnmc/common/byte_reader.h"
#include "libnmc/common/checksum.h"
#include "libnmc/common/coefficient_coder.h"
#include "libnmc/common/format.h"
#include "libnmc/common/hash.h"
#include "libnmc/decode/range_decoder.h"
#include "tests/spec/spec_document.h"
#include "tests/support/stream_decoding.h"
#include "tests/unit/common/small_meshes.h"

using namespace nmc;
using namespace nmc::test;

namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes bytes_of(const std::string& text) {
  Bytes bytes;
  for (const std::string& word : words_of(text)) {
    REQUIRE(word.size() == 2);
    bytes.push_back(static_cast<std::uint8_t>(std::stoul(word, nullptr, 16)));
  }
  return bytes;
}

std::string hex(std::uint64_t value, int digits) {
  char text[20];
  std::snprintf(text, sizeof text, "%0*llx", digits, static_cast<unsigned long long>(value));
  return text;
}

/// Both sides of "left => right".
struct Sides {
  std::string left, right;
};
Sides sides_of(const std::string& line) {
  const std::size_t arrow = line.find("=>");
  INFO(line);
  REQUIRE(arrow != std::string::npos);
  const Words right = words_of(line.substr(arrow + 2));
  std::string joined;
  for (const std::string& word : right) joined += (joined.empty() ? "" : " "), joined += word;
  return {line.substr(0, arrow), joined};
}

void run_varint(const Sides& sides) {
  const Bytes bytes = bytes_of(sides.left);
  ByteReader reader(bytes.data(), bytes.size());
  const std::uint64_t value = reader.read_varint();
  CHECK((reader.malformed() ? "error" : std::to_string(value)) == sides.right);
  std::uint64_t second = 0;
  const bool is_good = nmc_reference::read_varint(bytes, second);
  CHECK((is_good ? std::to_string(second) : "error") == sides.right);
}

void run_svarint(const Sides& sides) {
  const Bytes bytes = bytes_of(sides.left);
  ByteReader reader(bytes.data(), bytes.size());
  CHECK(std::to_string(reader.read_signed_varint()) == sides.right);
}

void run_crc32c(const Sides& sides) {
  const Bytes bytes = bytes_of(sides.left);
  CHECK(hex(crc32c(bytes.data(), bytes.size()), 8) == sides.right);
  CHECK(hex(nmc_reference::crc32c(bytes.data(), bytes.size()), 8) == sides.right);
}

void run_step(const Sides& sides) {
  const Words words = words_of(sides.left);
  const double step = std::stod(words.at(0)), expected = std::stod(sides.right);
  CHECK(step_from_code(step, static_cast<std::uint8_t>(std::stoi(words.at(1)))) == expected);
  CHECK(nmc_reference::step_of_code(step, std::stoi(words.at(1))) == expected);
}

void run_error_code(const Sides& sides) {
  const auto code = static_cast<std::uint16_t>(std::stoi(sides.left));
  CHECK(error_from_code(code, 1.0) == Approx(std::stod(sides.right)).epsilon(1e-12));
}

void run_arithmetic(const Sides& sides) {
  const std::size_t p = sides.left.find('p');
  REQUIRE(p != std::string::npos);
  const Bytes payload = bytes_of(sides.left.substr(0, p));
  std::vector<std::uint32_t> probabilities;
  for (const std::string& word : words_of(sides.left.substr(p + 1)))
    probabilities.push_back(static_cast<std::uint32_t>(std::stoul(word)));
  RangeDecoder coder(payload.data(), payload.size());
  std::string library, reference;
  for (const std::uint32_t probability : probabilities)
    library += (library.empty() ? "" : " "), library += std::to_string(coder.code(0, probability));
  for (const int bit : nmc_reference::decisions(payload, probabilities))
    reference += (reference.empty() ? "" : " "), reference += std::to_string(bit);
  CHECK(library == sides.right);
  CHECK(reference == sides.right);
}

void run_energy_class(const Sides& sides) {
  const int x = std::stoi(sides.left);
  CHECK(coefficient_internal::energy_class(x) == std::stoi(sides.right));
  CHECK(nmc_reference::energy_class(x) == std::stoi(sides.right));
}

void run_counts(const Sides& sides) {
  const Words words = words_of(sides.left);
  REQUIRE(words.at(0) == "tetrahedron");
  std::vector<LevelTopology> levels(1);
  REQUIRE(build(tetrahedron(), levels[0]).ok());
  for (int l = 0; l < std::stoi(words.at(2)); ++l) {
    LevelTopology fine;
    REQUIRE(subdivide(levels.back(), false, fine).ok());
    levels.push_back(std::move(fine));
  }
  const LevelTopology& last = levels.back();
  CHECK(std::to_string(last.vertex_count) + " vertices " + std::to_string(last.edge_count) + " edges " +
            std::to_string(last.face_count) + " faces" ==
        sides.right);
}

void run_hash(const Sides& sides) {
  Hash64 hash;
  std::vector<std::uint32_t> words;
  for (const std::string& word : words_of(sides.left))
    words.push_back(static_cast<std::uint32_t>(std::stoul(word, nullptr, 16)));
  for (const std::uint32_t word : words) hash.add_u32(word);
  CHECK(hex(hash.value(), 16) == sides.right);
  CHECK(hex(nmc_reference::hash_of(words), 16) == sides.right);
}

void run_squash(const Sides& sides) {
  CHECK(squash(std::stoi(sides.left)) == std::stoul(sides.right));
  CHECK(nmc_reference::squash(std::stoi(sides.left)) == std::stoi(sides.right));
}

void run_stretch(const Sides& sides) {
  CHECK(stretch(static_cast<std::uint32_t>(std::stoul(sides.left))) == std::stoi(sides.right));
  CHECK(nmc_reference::stretch(std::stoi(sides.left)) == std::stoi(sides.right));
}

void run_cosine(const Sides& sides) {
  const Words words = words_of(sides.left);
  CHECK(nmc_reference::cosine(static_cast<std::uint32_t>(std::stoul(words.at(0))),
                              static_cast<std::uint32_t>(std::stoul(words.at(1)))) == std::stod(sides.right));
}

/// Lines of bytes, then per row "=> END LEVEL STATE POSITIONS", at last "=> OK" or "=> CODE OFFSET SECTION".
void run_stream(const Example& example) {
  Bytes bytes;
  std::string expected, library, reference;
  for (const std::string& line : example.lines) {
    if (line.rfind("=>", 0) == 0) {
      expected += sides_of(line).right + "\n";
    } else {
      const Bytes more = bytes_of(line);
      bytes.insert(bytes.end(), more.begin(), more.end());
    }
  }
  const Decoding decoding = decode(bytes);
  for (const DecodedLayer& layer : decoding.layers) {
    library += std::to_string(layer.end_offset) + " " + std::to_string(layer.level) + " " +
               hex(layer.state_hash, 16) + " " + hex(layer.position_hash, 16) + "\n";
  }
  library += decoding.status == NMC_OK
                 ? "OK\n"
                 : std::string(nmc_status_name(decoding.status)).substr(8) + " " +
                       std::to_string(decoding.error.byte_offset) + " " + decoding.error.spec_section + "\n";
  const nmc_reference::Decoding second = nmc_reference::decode(bytes);
  for (const nmc_reference::Row& row : second.rows) {
    reference += std::to_string(row.end_offset) + " " + std::to_string(row.level) + " " +
                 hex(row.state_hash, 16) + " " + hex(row.position_hash, 16) + "\n";
  }
  reference += second.code == nmc_reference::Code::kOk
                   ? "OK\n"
                   : std::string(name_of(second.code)) + " " + std::to_string(second.offset) + " " +
                         second.section + "\n";
  CHECK(library == expected);
  CHECK(reference == expected);
}

}  // namespace

TEST_CASE("spec: every example does what it says, in the library and in the reference decoder", "[spec]") {
  const std::map<std::string, std::function<void(const Sides&)>> kinds = {{"varint", run_varint},
                                                                          {"svarint", run_svarint},
                                                                          {"crc32c", run_crc32c},
                                                                          {"step", run_step},
                                                                          {"error_code", run_error_code},
                                                                          {"arithmetic", run_arithmetic},
                                                                          {"counts", run_counts},
                                                                          {"hash", run_hash},
                                                                          {"energy_class", run_energy_class},
                                                                          {"squash", run_squash},
                                                                          {"stretch", run_stretch},
                                                                          {"cosine", run_cosine}};
  std::map<std::string, int> count;
  for (const Example& example : SpecDocument().examples()) {
    INFO("example " << example.kind);
    ++count[example.kind];
    REQUIRE(!example.lines.empty());
    if (example.kind == "stream") {
      run_stream(example);
      continue;
    }
    REQUIRE(kinds.count(example.kind) == 1);  // an example that nobody runs is none
    for (const std::string& line : example.lines) {
      INFO(line);
      kinds.at(example.kind)(sides_of(line));
    }
  }
  for (const auto& [kind, run] : kinds) {
    INFO("no example of kind " << kind);
    CHECK(count[kind] >= 1);
  }
  CHECK(count["stream"] >= 3);
}

// SPDX-License-Identifier: Apache-2.0
#include "encoder/read/gltf_document.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <filesystem>
#include <string_view>
#include <utility>

#include "encoder/read/binary_load.h"

namespace nmc {

namespace {

using nlohmann::json;

constexpr std::size_t kContainerHeaderSize = 12;
constexpr std::size_t kChunkHeaderSize = 8;
constexpr std::uint32_t kJsonChunk = 0x4E4F534A;
constexpr std::uint32_t kBinaryChunk = 0x004E4942;

constexpr std::array<const char*, 3> kCompressions = {"KHR_draco_mesh_compression", "EXT_meshopt_compression",
                                                      "KHR_meshopt_compression"};

/// Extensions that leave the surface as it is, or that this reader implements.
bool is_harmless(std::string_view extension) {
  static constexpr std::array<std::string_view, 11> kPrefixes = {"KHR_materials_",
                                                                 "EXT_materials_",
                                                                 "KHR_texture_",
                                                                 "EXT_texture_",
                                                                 "MSFT_texture_",
                                                                 "KHR_lights_",
                                                                 "EXT_lights_",
                                                                 "KHR_xmp",
                                                                 "KHR_animation_pointer",
                                                                 "KHR_mesh_quantization",
                                                                 "EXT_mesh_gpu_instancing"};
  return std::any_of(kPrefixes.begin(), kPrefixes.end(),
                     [&](std::string_view prefix) { return extension.starts_with(prefix); });
}

int base64_digit(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  if (c == '+') return 62;
  if (c == '/') return 63;
  return -1;
}

/// RFC 4648, section 4. Nothing where a character is foreign or the length is impossible.
std::optional<std::vector<char>> base64_decoded(std::string_view text) {
  for (int padding = 0; padding < 2 && text.ends_with('='); ++padding) text.remove_suffix(1);
  if (text.size() % 4 == 1) return std::nullopt;
  std::vector<char> bytes;
  bytes.reserve(text.size() / 4 * 3 + 2);
  std::uint32_t bits = 0;
  int bit_count = 0;
  for (const char c : text) {
    const int digit = base64_digit(c);
    if (digit < 0) return std::nullopt;
    bits = (bits << 6) | static_cast<std::uint32_t>(digit);
    bit_count += 6;
    if (bit_count >= 8) {
      bit_count -= 8;
      bytes.push_back(static_cast<char>((bits >> bit_count) & 0xff));
    }
  }
  return bytes;
}

int hexadecimal_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

std::string percent_decoded(std::string_view uri) {
  std::string text;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    if (uri[i] == '%' && i + 2 < uri.size()) {
      const int high = hexadecimal_digit(uri[i + 1]), low = hexadecimal_digit(uri[i + 2]);
      if (high >= 0 && low >= 0) {
        text.push_back(static_cast<char>(16 * high + low));
        i += 2;
        continue;
      }
    }
    text.push_back(uri[i]);
  }
  return text;
}

/// A file beside or below the glTF file. Anything else would let a foreign file choose what is read.
bool stays_in_folder(const std::filesystem::path& file) {
  if (file.empty() || file.is_absolute() || file.string().find('\0') != std::string::npos) return false;
  return std::none_of(file.begin(), file.end(), [](const auto& part) { return part == ".."; });
}

std::string without_exception_id(std::string_view what) {
  const std::size_t bracket = what.find("] ");
  return std::string(bracket == std::string_view::npos ? what : what.substr(bracket + 2));
}

}  // namespace

GltfDocument::GltfDocument(const Source& source) : source_(source) {
  parse_container();
  const GltfObject root{&root_, "glTF"};
  const json* const asset = member(root, "asset");
  if (asset == nullptr || !asset->is_object()) fail("asset", "missing, so this is not glTF");
  const std::string version = string_member({asset, "asset"}, "version");
  if (!version.starts_with("2."))
    fail("asset", fmt::format("glTF version '{}', but nmc reads 2.0", version.substr(0, 20)),
         ExitCode::kUnsupported);
  check_extensions();
}

void GltfDocument::fail(const std::string& path, const std::string& reason, ExitCode code) const {
  source_.fail(fmt::format("{}: {}", path, reason), code);
}

void GltfDocument::parse_container() {
  const std::span<const char> file(source_.begin(), source_.data.size());
  if (!std::string_view(file.data(), file.size()).starts_with("glTF")) {
    parse_json(file);
    return;
  }
  const auto word = [&](std::size_t offset) {
    return load<std::uint32_t>(file.data() + offset, std::endian::little);
  };
  if (file.size() < kContainerHeaderSize)
    source_.fail_at_byte(source_.end(), "the file ends within the GLB header");
  if (word(4) != 2)
    source_.fail_at_byte(file.data() + 4, fmt::format("GLB version {}, but nmc reads version 2", word(4)),
                         ExitCode::kUnsupported);
  if (word(8) > file.size())
    source_.fail_at_byte(source_.end(),
                         fmt::format("the file ends before the {} bytes its header states", word(8)));
  const std::size_t end = word(8);
  std::optional<std::span<const char>> text;
  for (std::size_t at = kContainerHeaderSize; at < end;) {
    if (end - at < kChunkHeaderSize) source_.fail_at_byte(file.data() + at, "a GLB chunk header is cut off");
    const std::size_t size = word(at);
    const std::uint32_t type = word(at + 4);
    at += kChunkHeaderSize;
    if (size > end - at)
      source_.fail_at_byte(file.data() + at,
                           fmt::format("a GLB chunk of {} bytes, but {} are left", size, end - at));
    if (type == kJsonChunk && !text) {
      text = file.subspan(at, size);
    } else if (type == kBinaryChunk && text && !binary_chunk_) {
      binary_chunk_ = file.subspan(at, size);
    }
    at += std::min((size + 3) / 4 * 4, end - at);
  }
  if (!text) source_.fail_at_byte(file.data() + kContainerHeaderSize, "the GLB container has no JSON chunk");
  parse_json(*text);
}

void GltfDocument::parse_json(std::span<const char> text) {
  try {
    root_ = json::parse(text.begin(), text.end());
  } catch (const json::parse_error& error) {
    const std::size_t offset = std::min(error.byte > 0 ? error.byte - 1 : 0, text.size());
    source_.fail_at_byte(text.data() + offset, "malformed JSON: " + without_exception_id(error.what()));
  } catch (const json::exception& error) {
    source_.fail_at_byte(text.data(), "malformed JSON: " + without_exception_id(error.what()));
  }
  if (!root_.is_object()) source_.fail_at_byte(text.data(), "not a glTF file: its JSON is no object");
}

void GltfDocument::check_extensions() const {
  const auto required = root_.find("extensionsRequired");
  if (required == root_.end() || !required->is_array()) return;
  for (const json& entry : *required) {
    const std::string name = entry.is_string() ? entry.get<std::string>() : std::string();
    if (std::find(kCompressions.begin(), kCompressions.end(), name) != kCompressions.end())
      fail("extensionsRequired",
           fmt::format(
               "the meshes are compressed with {}, which nmc does not read; decompress the file first", name),
           ExitCode::kUnsupported);
    if (!is_harmless(name))
      fail("extensionsRequired",
           fmt::format("the file requires {}, which nmc does not know", name.substr(0, 60)),
           ExitCode::kUnsupported);
  }
}

const json* GltfDocument::member(const GltfObject& object, const char* key) const {
  const auto found = object.json->find(key);
  return found == object.json->end() ? nullptr : &*found;
}

std::size_t GltfDocument::count(const char* array) const {
  const auto found = root_.find(array);
  if (found == root_.end()) return 0;
  if (!found->is_array()) fail(array, "not an array");
  return found->size();
}

GltfObject GltfDocument::element(const char* array, std::uint64_t index, const std::string& user) const {
  const std::size_t size = count(array);
  if (index >= size) fail(user, fmt::format("refers to {}[{}], but there are {}", array, index, size));
  GltfObject object{&root_[array][index], fmt::format("{}[{}]", array, index)};
  if (!object.json->is_object()) fail(object.path, "not an object");
  return object;
}

std::uint64_t GltfDocument::unsigned_member(const GltfObject& object, const char* key,
                                            std::optional<std::uint64_t> fallback) const {
  const json* const value = member(object, key);
  if (value == nullptr) {
    if (!fallback) fail(object.path, fmt::format("'{}' is missing", key));
    return *fallback;
  }
  if (value->is_number_unsigned()) return value->get<std::uint64_t>();
  if (value->is_number_float()) {  // some writers print 3.0
    const double real = value->get<double>();
    if (real >= 0 && real <= 9.0e15 && real == static_cast<double>(static_cast<std::uint64_t>(real)))
      return static_cast<std::uint64_t>(real);
  }
  fail(object.path, fmt::format("'{}' is not a non-negative integer", key));
}

std::string GltfDocument::string_member(const GltfObject& object, const char* key) const {
  const json* const value = member(object, key);
  if (value == nullptr) return {};
  if (!value->is_string()) fail(object.path, fmt::format("'{}' is not a text", key));
  return value->get<std::string>();
}

bool GltfDocument::boolean_member(const GltfObject& object, const char* key) const {
  const json* const value = member(object, key);
  if (value == nullptr) return false;
  if (!value->is_boolean()) fail(object.path, fmt::format("'{}' is neither true nor false", key));
  return value->get<bool>();
}

std::optional<std::vector<double>> GltfDocument::numbers_member(const GltfObject& object, const char* key,
                                                                std::size_t size) const {
  const json* const value = member(object, key);
  if (value == nullptr) return std::nullopt;
  if (!value->is_array() || value->size() != size)
    fail(object.path, fmt::format("'{}' is not an array of {} numbers", key, size));
  std::vector<double> numbers;
  for (const json& entry : *value) {
    if (!entry.is_number()) fail(object.path, fmt::format("'{}' is not an array of {} numbers", key, size));
    numbers.push_back(entry.get<double>());
  }
  return numbers;
}

bool GltfDocument::has_extension(const GltfObject& object, const char* name) const {
  const json* const extensions = member(object, "extensions");
  return extensions != nullptr && extensions->is_object() && extensions->contains(name);
}

GltfBufferView GltfDocument::buffer_view(std::uint64_t index, const std::string& user) {
  const GltfObject object = element("bufferViews", index, user);
  const std::uint64_t buffer_index = unsigned_member(object, "buffer");
  const GltfObject buffer_object = element("buffers", buffer_index, object.path);
  for (const char* const compression : kCompressions) {
    // The extension lets a plain copy stand beside the compressed bytes; without it the buffer is marked or
    // empty.
    const bool is_placeholder =
        has_extension(buffer_object, compression) ||
        (member(buffer_object, "uri") == nullptr && !(buffer_index == 0 && binary_chunk_.has_value()));
    if (has_extension(object, compression) && is_placeholder)
      fail(object.path,
           fmt::format("compressed with {}, which nmc does not read; decompress the file first", compression),
           ExitCode::kUnsupported);
  }
  const std::span<const char> bytes = buffer(buffer_index, object.path);
  const std::uint64_t offset = unsigned_member(object, "byteOffset", 0);
  const std::uint64_t length = unsigned_member(object, "byteLength");
  if (offset > bytes.size() || length > bytes.size() - offset)
    fail(object.path,
         fmt::format("bytes {} to {} of a buffer of {} bytes", offset, offset + length, bytes.size()));
  const std::uint64_t stride = unsigned_member(object, "byteStride", 0);
  if (stride > 252) fail(object.path, fmt::format("a byteStride of {}, but 252 is the largest", stride));
  return {bytes.subspan(offset, length), static_cast<std::size_t>(stride)};
}

std::span<const char> GltfDocument::buffer(std::uint64_t index, const std::string& user) {
  if (const auto known = buffers_.find(index); known != buffers_.end()) return known->second;
  const GltfObject object = element("buffers", index, user);
  const std::uint64_t length = unsigned_member(object, "byteLength");
  std::span<const char> bytes;
  if (member(object, "uri") != nullptr) {
    const std::string uri = string_member(object, "uri");
    bytes = uri.starts_with("data:") ? data_uri(object, uri) : side_file(object, uri);
  } else if (index == 0 && binary_chunk_) {
    bytes = *binary_chunk_;
  } else {
    fail(object.path, "has neither a uri nor the binary chunk of a GLB container");
  }
  if (length > bytes.size())
    fail(object.path, fmt::format("{} bytes are announced, but there are {}", length, bytes.size()));
  bytes = bytes.first(length);
  buffers_.emplace(index, bytes);
  return bytes;
}

std::span<const char> GltfDocument::data_uri(const GltfObject& object, const std::string& uri) {
  const std::size_t comma = uri.find(',');
  if (comma == std::string::npos || !std::string_view(uri).substr(0, comma).ends_with(";base64"))
    fail(object.path, "a data URI that is not base64");
  std::optional<std::vector<char>> bytes = base64_decoded(std::string_view(uri).substr(comma + 1));
  if (!bytes) fail(object.path, "its base64 data is malformed");
  return decoded_.emplace_back(std::move(*bytes));
}

std::span<const char> GltfDocument::side_file(const GltfObject& object, const std::string& uri) {
  const std::filesystem::path file(percent_decoded(uri));
  const std::string shown = uri.substr(0, 80);
  if (uri.find("://") != std::string::npos || !stays_in_folder(file))
    fail(object.path, fmt::format("'{}' is not a file beside this one, and others are not opened", shown),
         ExitCode::kUnsupported);
  if (source_.folder.empty())
    fail(object.path, fmt::format("its data is in '{}', which cannot be found from here", shown),
         ExitCode::kInputOutput);
  const std::span<const std::byte> bytes =
      side_files_.emplace_back(InputBytes::open((std::filesystem::path(source_.folder) / file).string()))
          .bytes();
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace nmc

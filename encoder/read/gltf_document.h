// SPDX-License-Identifier: Apache-2.0
// A glTF 2.0 file as checked JSON and bounds-checked byte ranges.
//
// Only what geometry needs is looked at; images are never opened. The JSON comes from nlohmann-json, whose
// parser and destructor do not recurse, so nesting cannot exhaust the stack. Buffers stay where they are: the
// binary chunk of a .glb is used in place. tinygltf is not used: its 2.7.0 reads eight bytes beyond a GLB
// whose binary chunk is eight bytes too long, leaves out a primitive it cannot parse instead of failing, and
// copies every buffer.
#ifndef NMC_ENCODER_READ_GLTF_DOCUMENT_H_
#define NMC_ENCODER_READ_GLTF_DOCUMENT_H_

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "encoder/read/input_bytes.h"
#include "encoder/read/source.h"

namespace nmc {

/// One object of the document with its path in it ("accessors[3]"), for messages.
struct GltfObject {
  const nlohmann::json* json = nullptr;
  std::string path;
};

struct GltfBufferView {
  std::span<const char> data;
  std::size_t stride = 0;  // 0: tightly packed
};

class GltfDocument {
 public:
  /// Parses .gltf text or a .glb container and refuses what cannot be read (version 1, required extensions
  /// that change geometry). Buffers are opened when they are first asked for.
  explicit GltfDocument(const Source& source);

  const nlohmann::json& root() const { return root_; }
  std::size_t byte_count() const { return source_.data.size(); }

  /// Throws "file: path: reason".
  [[noreturn]] void fail(const std::string& path, const std::string& reason,
                         ExitCode code = ExitCode::kInvalidInput) const;

  /// The member `key` of `object`, or null where there is none.
  const nlohmann::json* member(const GltfObject& object, const char* key) const;

  /// Elements of a top-level array such as "nodes"; 0 where it is missing.
  std::size_t count(const char* array) const;

  /// Element `index` of a top-level array; fails in the name of `user` where it does not exist or is no
  /// object.
  GltfObject element(const char* array, std::uint64_t index, const std::string& user) const;

  /// A non-negative integer member; `fallback` where it is missing, and without one a failure.
  std::uint64_t unsigned_member(const GltfObject& object, const char* key,
                                std::optional<std::uint64_t> fallback = std::nullopt) const;
  std::string string_member(const GltfObject& object, const char* key) const;
  bool boolean_member(const GltfObject& object, const char* key) const;

  /// The numbers of an array member of exactly `size` elements; nothing where it is missing.
  std::optional<std::vector<double>> numbers_member(const GltfObject& object, const char* key,
                                                    std::size_t size) const;

  /// True where `object` has the extension `name`.
  bool has_extension(const GltfObject& object, const char* name) const;

  /// The bytes of a buffer view. Fails with kUnsupported where they are only there in compressed form.
  GltfBufferView buffer_view(std::uint64_t index, const std::string& user);

 private:
  void parse_container();
  void parse_json(std::span<const char> text);
  void check_extensions() const;
  std::span<const char> buffer(std::uint64_t index, const std::string& user);
  std::span<const char> data_uri(const GltfObject& object, const std::string& uri);
  std::span<const char> side_file(const GltfObject& object, const std::string& uri);

  const Source& source_;
  nlohmann::json root_;
  std::optional<std::span<const char>> binary_chunk_;
  std::map<std::uint64_t, std::span<const char>> buffers_;
  std::deque<std::vector<char>> decoded_;
  std::deque<InputBytes> side_files_;
};

}  // namespace nmc

#endif  // NMC_ENCODER_READ_GLTF_DOCUMENT_H_

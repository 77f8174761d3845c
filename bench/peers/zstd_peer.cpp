// SPDX-License-Identifier: Apache-2.0
#include "bench/peers/zstd_peer.h"

#include <zstd.h>

#include <cstring>

#include "bench/peers/peer.h"
#include "encoder/core/error.h"

namespace nmc::bench {
namespace {

constexpr int kLevel = 19;

template <class T>
void append(std::vector<unsigned char>& bytes, const T& value) {
  const auto* first = reinterpret_cast<const unsigned char*>(&value);
  bytes.insert(bytes.end(), first, first + sizeof(T));
}

}  // namespace

std::vector<unsigned char> zstd_compress(const std::vector<unsigned char>& bytes) {
  std::vector<unsigned char> compressed(ZSTD_compressBound(bytes.size()));
  const std::size_t size =
      ZSTD_compress(compressed.data(), compressed.size(), bytes.data(), bytes.size(), kLevel);
  if (ZSTD_isError(size) != 0)
    throw Error(ExitCode::kInternal, std::string("zstd: ") + ZSTD_getErrorName(size));
  compressed.resize(size);
  return compressed;
}

std::vector<unsigned char> zstd_decompress(const std::vector<unsigned char>& bytes) {
  std::vector<unsigned char> plain(ZSTD_getFrameContentSize(bytes.data(), bytes.size()));
  const std::size_t size = ZSTD_decompress(plain.data(), plain.size(), bytes.data(), bytes.size());
  if (ZSTD_isError(size) != 0)
    throw Error(ExitCode::kInternal, std::string("zstd: ") + ZSTD_getErrorName(size));
  plain.resize(size);
  return plain;
}

CodecResult code_raw_with_zstd(const TriangleMesh& mesh) {
  CodecResult result;
  const Stopwatch encode_watch;
  std::vector<unsigned char> bytes;
  for (const Vec3& p : mesh.positions) {
    for (int i = 0; i < 3; ++i) append(bytes, static_cast<float>(p[i]));
  }
  for (const Triangle& triangle : mesh.triangles) append(bytes, triangle);
  const std::vector<unsigned char> compressed = zstd_compress(bytes);
  result.encode_seconds = encode_watch.seconds();
  result.bytes = compressed.size();

  const Stopwatch decode_watch;
  zstd_decompress(compressed);
  result.decode_seconds = decode_watch.seconds();
  result.decoded.triangles = mesh.triangles;
  for (const Vec3& p : mesh.positions) {
    result.decoded.positions.push_back(
        {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)});
  }
  return result;
}

}  // namespace nmc::bench

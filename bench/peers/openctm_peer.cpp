// SPDX-License-Identifier: Apache-2.0
#include <openctm.h>

#include <algorithm>
#include <cstring>

#include "bench/peers/peer.h"
#include "encoder/core/error.h"

namespace nmc::bench {
namespace {

CTMuint append(const void* bytes, CTMuint count, void* user) {
  auto& buffer = *static_cast<std::vector<unsigned char>*>(user);
  const auto* first = static_cast<const unsigned char*>(bytes);
  buffer.insert(buffer.end(), first, first + count);
  return count;
}

struct Cursor {
  const std::vector<unsigned char>& buffer;
  std::size_t offset = 0;
};

CTMuint take(void* bytes, CTMuint count, void* user) {
  auto& cursor = *static_cast<Cursor*>(user);
  const std::size_t taken = std::min<std::size_t>(count, cursor.buffer.size() - cursor.offset);
  std::memcpy(bytes, cursor.buffer.data() + cursor.offset, taken);
  cursor.offset += taken;
  return static_cast<CTMuint>(taken);
}

void check(CTMcontext context, const char* what) {
  const CTMenum error = ctmGetError(context);
  if (error == CTM_NONE) return;
  throw Error(ExitCode::kUnsupported, std::string("OpenCTM ") + what + ": " + ctmErrorString(error));
}

struct Context {
  explicit Context(CTMenum mode) : handle(ctmNewContext(mode)) {}
  ~Context() { ctmFreeContext(handle); }
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;
  CTMcontext handle;
};

}  // namespace

CodecResult code_with_openctm(const TriangleMesh& mesh, int position_bits) {
  const BoundingBox box = bounding_box(mesh);
  const Vec3 center = box.center();
  const Vec3 size = box.maximum - box.minimum;
  const double step = std::max({size.x, size.y, size.z}) / ((1 << position_bits) - 1);
  std::vector<CTMfloat> positions;
  for (const Vec3& point : mesh.positions) {
    const Vec3 p = point - center;
    for (int i = 0; i < 3; ++i) positions.push_back(static_cast<CTMfloat>(p[i]));
  }
  std::vector<CTMuint> indices;
  for (const Triangle& triangle : mesh.triangles)
    indices.insert(indices.end(), triangle.begin(), triangle.end());
  CodecResult result;

  const Stopwatch encode_watch;
  std::vector<unsigned char> bytes;
  {
    const Context context(CTM_EXPORT);
    ctmDefineMesh(context.handle, positions.data(), static_cast<CTMuint>(mesh.vertex_count()), indices.data(),
                  static_cast<CTMuint>(mesh.triangle_count()), nullptr);
    ctmCompressionMethod(context.handle, CTM_METHOD_MG2);
    ctmCompressionLevel(context.handle, 9);
    ctmVertexPrecision(context.handle, static_cast<CTMfloat>(step));
    check(context.handle, "cannot take the mesh");
    ctmSaveCustom(context.handle, append, &bytes);
    check(context.handle, "cannot encode");
  }
  result.encode_seconds = encode_watch.seconds();
  result.bytes = bytes.size();

  const Stopwatch decode_watch;
  const Context context(CTM_IMPORT);
  Cursor cursor{bytes};
  ctmLoadCustom(context.handle, take, &cursor);
  check(context.handle, "cannot decode");
  result.decode_seconds = decode_watch.seconds();
  const CTMfloat* p = ctmGetFloatArray(context.handle, CTM_VERTICES);
  const CTMuint* corner = ctmGetIntegerArray(context.handle, CTM_INDICES);
  const CTMuint vertex_count = ctmGetInteger(context.handle, CTM_VERTEX_COUNT);
  const CTMuint triangle_count = ctmGetInteger(context.handle, CTM_TRIANGLE_COUNT);
  for (CTMuint v = 0; v < vertex_count; ++v, p += 3) {
    result.decoded.positions.push_back(center + Vec3{p[0], p[1], p[2]});
  }
  for (CTMuint t = 0; t < triangle_count; ++t, corner += 3) {
    result.decoded.triangles.push_back({corner[0], corner[1], corner[2]});
  }
  return result;
}

}  // namespace nmc::bench

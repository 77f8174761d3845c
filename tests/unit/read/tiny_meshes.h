// SPDX-License-Identifier: Apache-2.0
// One tiny valid file for every branch of every reader: what the truncation and mutation tests and the fuzz
// targets start from.
#ifndef NMC_TESTS_UNIT_READ_TINY_MESHES_H_
#define NMC_TESTS_UNIT_READ_TINY_MESHES_H_

#include <string>
#include <vector>

#include "encoder/read/mesh_reader.h"
#include "tests/unit/read/byte_builder.h"
#include "tests/unit/read/gltf_builder.h"

namespace nmc::test {

struct TinyMesh {
  std::string name;
  MeshFormat format;
  std::string bytes;
  std::size_t first_complete_prefix;  // every shorter prefix must be refused; 0: the format cannot tell
};

inline TinyMesh tiny_text(const char* name, MeshFormat format, const std::string& text) {
  return {name, format, text, text.size() - 1};  // the last line feed may be missing
}

inline TinyMesh tiny_binary(const char* name, MeshFormat format, const std::string& bytes) {
  return {name, format, bytes, bytes.size()};
}

inline TinyMesh tiny_ply(bool big_endian) {
  Bytes bytes(big_endian);
  bytes.text(
      std::string("ply\nformat binary_") + (big_endian ? "big" : "little") +
      "_endian 1.0\nelement vertex 4\nproperty float x\nproperty double y\nproperty float z\n"
      "property float quality\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
      "element face 1\nproperty list uchar int vertex_indices\nelement tristrips 1\n"
      "property list int int vertex_indices\nelement other 1\nproperty list ushort double a\nend_header\n");
  for (int i = 0; i < 4; ++i) {
    bytes.number(static_cast<float>(i % 2)).number(static_cast<double>(i / 2)).number(0.5f).number(1.0f);
    bytes.text("abc");
  }
  bytes.number(std::uint8_t{4}).numbers<std::int32_t>({0, 1, 3, 2});
  bytes.number(std::int32_t{5}).numbers<std::int32_t>({0, 1, 2, -1, 3});
  bytes.number(std::uint16_t{1}).number(1.0);
  return tiny_binary(big_endian ? "ply big-endian" : "ply little-endian", MeshFormat::kPly, bytes.string());
}

inline TinyMesh tiny_stl() {
  Bytes bytes;
  bytes.text(std::string(80, 'h')).number(std::uint32_t{2});
  for (int i = 0; i < 2; ++i)
    bytes.numbers<float>({0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0}).number(static_cast<std::uint16_t>(i));
  return tiny_binary("stl binary", MeshFormat::kStl, bytes.string());
}

inline TinyMesh tiny_off(bool big_endian) {
  Bytes bytes(big_endian);
  bytes.text(big_endian ? "CNOFF BINARY\n" : "OFF BINARY\n").numbers<std::uint32_t>({4, 1, 0});
  for (int i = 0; i < 4; ++i) {
    bytes.numbers<float>({static_cast<float>(i % 2), static_cast<float>(i / 2), 0});
    if (big_endian) bytes.numbers<float>({0, 0, 1}).numbers<float>({1, 0, 0, 1});
  }
  bytes.numbers<std::uint32_t>({4, 0, 1, 3, 2});
  if (big_endian) bytes.number(std::uint32_t{3}).numbers<float>({1, 0, 0});
  return tiny_binary(big_endian ? "off big-endian" : "off little-endian", MeshFormat::kOff, bytes.string());
}

/// Two instances of a sparse, strided, coloured strip and an instanced quantized triangle.
inline std::string tiny_gltf_json(const std::string& buffer_uri) {
  return R"({"asset":{"version":"2.0"},"extensionsRequired":["KHR_mesh_quantization","EXT_mesh_gpu_instancing"],
"scene":0,"scenes":[{"nodes":[0,2]}],"nodes":[{"mesh":0,"children":[1],"translation":[1,2,3]},
{"mesh":0,"matrix":[-1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]},
{"mesh":1,"extensions":{"EXT_mesh_gpu_instancing":{"attributes":{"TRANSLATION":4,"SCALE":4}}}}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0,"COLOR_0":1},"indices":2,"mode":5}]},
{"primitives":[{"attributes":{"POSITION":3}},{"attributes":{"POSITION":3},"mode":6},{"attributes":{"POSITION":3},"mode":1}]}],
"accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","sparse":{"count":1,
"indices":{"bufferView":2,"componentType":5121},"values":{"bufferView":3}}},
{"bufferView":0,"byteOffset":12,"componentType":5121,"normalized":true,"count":4,"type":"VEC4"},
{"bufferView":1,"componentType":5123,"count":5,"type":"SCALAR"},
{"bufferView":4,"componentType":5122,"normalized":true,"count":3,"type":"VEC3"},
{"bufferView":3,"componentType":5126,"count":1,"type":"VEC3"}],
"bufferViews":[{"buffer":0,"byteLength":64,"byteStride":16},{"buffer":0,"byteOffset":64,"byteLength":10},
{"buffer":0,"byteOffset":74,"byteLength":1},{"buffer":0,"byteOffset":76,"byteLength":12},
{"buffer":0,"byteOffset":88,"byteLength":24,"byteStride":8}],
"buffers":[{"byteLength":112)" +
         buffer_uri + "}]}";
}

inline std::string tiny_gltf_buffer() {
  Bytes bytes;
  for (int i = 0; i < 4; ++i)
    bytes.numbers<float>({static_cast<float>(i % 2), static_cast<float>(i / 2), 0})
        .numbers<std::uint8_t>({255, 128, 0, 255});
  bytes.numbers<std::uint16_t>({0, 1, 2, 2, 3}).number(std::uint8_t{3}).number(std::uint8_t{0});
  bytes.numbers<float>({2, 2, 2});
  for (int i = 0; i < 3; ++i)
    bytes.numbers<std::int16_t>(
        {static_cast<std::int16_t>(i * 10000), static_cast<std::int16_t>(i % 2 * -32768), 0, 0});
  return bytes.string();
}

inline std::vector<TinyMesh> tiny_meshes() {
  std::vector<TinyMesh> meshes;
  meshes.push_back(
      tiny_text("ply text", MeshFormat::kPly,
                "ply\nformat ascii 1.0\ncomment TextureFile a.png\nelement vertex 4\nproperty float x\n"
                "property float y\nproperty double z\nproperty float red\nproperty float green\n"
                "property float blue\nproperty float nx\nelement face 2\n"
                "property list uchar int vertex_indices\nend_header\n0 0 0 1 0 0 1\n1 0 0 0 1 0 1\n"
                "1 1 0 0 0 1 1\n0 1 0 0 0 1 nan\n4 0 1 2 3\n3 0 1 2\n"));
  meshes.push_back(tiny_ply(false));
  meshes.push_back(tiny_ply(true));
  meshes.push_back(
      {"obj", MeshFormat::kObj,
       "mtllib a.mtl\nv 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 1 1 0\nvt 0 0\nvn 0 0 1\nv 0 1e0 -0.5\n"
       "#MRGB ffff0000\nf 1/1/1 2//1 3 4/1\nf -1 -2 \\\n -3\nl 1 2\nf 9 9 9\n# end\nv 1 2 3\nv 1 2 3\n"
       "v 1 2 3\nv 1 2 3\nv 1 2 3\n",
       0});
  meshes.push_back(tiny_stl());
  meshes.push_back(
      tiny_text("stl text", MeshFormat::kStl,
                "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
                "vertex 0.1 0.1 0\nendloop\nendfacet\nendsolid\n"));
  meshes.push_back(tiny_text("off text", MeshFormat::kOff,
                             "COFF\n# c\n4 3 0\n0 0 0 1 0 0 1\n1 0 0 0 1 0 1\n1 1 0 0 0 1 1\n0 1 0 0 0 0 1\n"
                             "4 0 1 2 3 255 0 0\n2 0 1\n3 0 1 2\n"));
  meshes.push_back(tiny_off(false));
  meshes.push_back(tiny_off(true));
  meshes.push_back(tiny_binary("glb", MeshFormat::kGltf, glb(tiny_gltf_json(""), tiny_gltf_buffer())));
  meshes.push_back(tiny_binary("gltf", MeshFormat::kGltf,
                               tiny_gltf_json(R"(,"uri":"data:application/octet-stream;base64,)" +
                                              base64(tiny_gltf_buffer()) + "\"")));
  return meshes;
}

}  // namespace nmc::test

#endif  // NMC_TESTS_UNIT_READ_TINY_MESHES_H_

// SPDX-License-Identifier: Apache-2.0
// Every writer through the reader of the same format, which has tests of its own.
#include "decoder/write/mesh_writer.h"

#include <sys/stat.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>

#include "encoder/read/mesh_reader.h"

namespace nmc {
namespace {

namespace fs = std::filesystem;

constexpr std::pair<OutputFormat, const char*> kFormats[] = {
    {OutputFormat::kPly, "binary.ply"}, {OutputFormat::kPlyText, "text.ply"}, {OutputFormat::kObj, "a.obj"},
    {OutputFormat::kStl, "a.stl"},      {OutputFormat::kOff, "a.off"},        {OutputFormat::kGlb, "a.glb"},
};

class Folder {
 public:
  Folder() : path_(fs::temp_directory_path() / ("nmc-write-test-" + std::to_string(::getpid()))) {
    fs::create_directories(path_);
  }
  ~Folder() { fs::remove_all(path_); }
  std::string operator/(const char* name) const { return (path_ / name).string(); }
  std::size_t file_count() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(path_), fs::directory_iterator()));
  }

 private:
  fs::path path_;
};

std::string content(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

/// A wavy strip with coordinates that need all their digits, every colour value and unit normals.
struct Sample {
  std::vector<float> single;
  std::vector<double> exact;
  std::vector<std::uint32_t> triangles;
  std::vector<std::uint8_t> colors;
  std::vector<float> normals;

  explicit Sample(double offset = 0) {
    constexpr std::uint32_t kCount = 256;
    for (std::uint32_t i = 0; i < kCount; ++i) {
      const double angle = 0.1 * i;
      for (const double value : {std::cos(angle) / 3, std::sin(angle) * std::numbers::pi, 1e-3 * i * i}) {
        exact.push_back(offset + value);
        single.push_back(static_cast<float>(value));
      }
      for (const std::uint32_t value : {i, 255 - i, (i * 37) % 256})
        colors.push_back(static_cast<std::uint8_t>(value));
      for (const double value : {std::cos(angle), std::sin(angle), 0.0})
        normals.push_back(static_cast<float>(value));
      if (i >= 2) triangles.insert(triangles.end(), {i - 2, i % 2 ? i : i - 1, i % 2 ? i - 1 : i});
    }
  }

  MeshView view(bool as_double) const {
    MeshView view;
    if (as_double) {
      view.positions_double = exact;
    } else {
      view.positions_single = single;
    }
    view.triangles = triangles;
    return view;
  }
};

void check_triangles(const TriangleMesh& mesh, const std::vector<std::uint32_t>& expected) {
  REQUIRE(mesh.triangle_count() == expected.size() / 3);
  for (std::size_t i = 0; i < expected.size(); ++i)
    if (mesh.triangles[i / 3][i % 3] != expected[i])
      FAIL("corner " << i << " is vertex " << mesh.triangles[i / 3][i % 3] << ", not " << expected[i]);
}

/// The largest distance between stored and expected coordinates, in the precision that was written; STL
/// repeats its vertices per triangle.
double largest_difference(const TriangleMesh& mesh, OutputFormat format, const Sample& sample,
                          bool as_double) {
  double largest = 0;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const std::size_t vertex = format == OutputFormat::kStl ? sample.triangles[i] : i;
    for (int k = 0; k < 3; ++k) {
      const std::size_t at = 3 * vertex + static_cast<std::size_t>(k);
      const double expected = as_double ? sample.exact[at] : static_cast<double>(sample.single[at]);
      const double stored = mesh.positions[i][k];
      largest = std::max(largest, std::abs((as_double ? stored : static_cast<float>(stored)) - expected));
    }
  }
  return largest;
}

TEST_CASE("write_mesh: positions and triangles come back exactly in every format", "[write]") {
  const Folder folder;
  const Sample sample;
  for (const auto& [format, name] : kFormats) {
    for (const bool as_double : {false, true}) {
      CAPTURE(name, as_double);
      const WriteStatus status = write_mesh(folder / name, sample.view(as_double), format);
      REQUIRE(status.message == "");
      const TriangleMesh mesh = read_mesh(folder / name);
      const bool is_single = format == OutputFormat::kStl || format == OutputFormat::kGlb;
      const double largest = largest_difference(mesh, format, sample, as_double);
      if (as_double && is_single) {
        CHECK(largest < 66 * std::numeric_limits<float>::epsilon());
      } else {
        CHECK(largest == 0);
      }
      if (format == OutputFormat::kStl) {
        CHECK(mesh.triangle_count() == sample.triangles.size() / 3);
      } else {
        check_triangles(mesh, sample.triangles);
      }
    }
  }
  CHECK(folder.file_count() == std::size(kFormats));
}

TEST_CASE("write_mesh: colours and normals come back exactly", "[write][colour]") {
  const Folder folder;
  const Sample sample;
  for (const auto& [format, name] : kFormats) {
    CAPTURE(name);
    MeshView view = sample.view(false);
    view.colors = sample.colors;
    view.normals = sample.normals;
    REQUIRE(write_mesh(folder / name, view, format).message == "");
    const TriangleMesh mesh = read_mesh(folder / name);
    if (format == OutputFormat::kStl) continue;
    check_triangles(mesh, sample.triangles);
    REQUIRE(mesh.colors.size() == mesh.vertex_count());
    for (std::size_t i = 0; i < sample.colors.size(); ++i)
      if (mesh.colors[i / 3][i % 3] != sample.colors[i])
        FAIL("colour component " << i << " is " << int{mesh.colors[i / 3][i % 3]} << ", not "
                                 << int{sample.colors[i]});
    if (format == OutputFormat::kObj || format == OutputFormat::kGlb) {
      CHECK_FALSE(mesh.dropped_properties.empty());
    } else {
      REQUIRE(mesh.attributes.size() == 3);
      for (std::size_t i = 0; i < sample.normals.size(); ++i)
        if (mesh.attributes[i % 3].values[i / 3] != sample.normals[i])
          FAIL("normal component " << i << " differs");
    }
  }
}

TEST_CASE("write_mesh: dark colours are not mistaken for a scale of 0 to 1", "[write][colour]") {
  const Folder folder;
  const Sample sample;
  MeshView view = sample.view(false);
  const std::vector<std::uint8_t> dark(sample.colors.size(), 1);
  view.colors = dark;
  for (const auto& [format, name] : kFormats) {
    if (format == OutputFormat::kStl) continue;
    CAPTURE(name);
    REQUIRE(write_mesh(folder / name, view, format).message == "");
    CHECK(read_mesh(folder / name).colors.at(7) == std::array<std::uint8_t, 3>{1, 1, 1});
  }
}

TEST_CASE("write_mesh: a mesh far from the origin keeps its detail in GLB", "[write][glb]") {
  const Folder folder;
  const Sample sample(1e7);
  REQUIRE(write_mesh(folder / "far.glb", sample.view(true), OutputFormat::kGlb).message == "");
  const TriangleMesh mesh = read_mesh(folder / "far.glb");
  CHECK(largest_difference(mesh, OutputFormat::kGlb, sample, true) < 1e-5);  // one float step at 1e7 is 1
}

/// The JSON of a .glb, after checks of everything that the container's definition fixes.
nlohmann::json checked_glb_json(const std::string& bytes, std::size_t& binary_size) {
  const auto word = [&](std::size_t at) {
    std::uint32_t value = 0;
    for (std::size_t k = 0; k < 4; ++k)
      value |= std::uint32_t{static_cast<std::uint8_t>(bytes.at(at + k))} << (8 * k);
    return value;
  };
  REQUIRE(bytes.substr(0, 4) == "glTF");
  CHECK(word(4) == 2);
  CHECK(word(8) == bytes.size());
  const std::size_t json_size = word(12);
  CHECK(json_size % 4 == 0);
  CHECK(bytes.substr(16, 4) == "JSON");
  binary_size = 0;
  if (20 + json_size < bytes.size()) {
    binary_size = word(20 + json_size);
    CHECK(binary_size % 4 == 0);
    CHECK(bytes.substr(24 + json_size, 4) == std::string("BIN\0", 4));
    CHECK(28 + json_size + binary_size == bytes.size());
  }
  return nlohmann::json::parse(bytes.substr(20, json_size));
}

TEST_CASE("write_mesh: GLB follows the rules of glTF 2.0", "[write][glb]") {
  const Folder folder;
  const Sample sample;
  MeshView view = sample.view(false);
  view.colors = sample.colors;
  view.normals = sample.normals;
  REQUIRE(write_mesh(folder / "a.glb", view, OutputFormat::kGlb).message == "");
  std::size_t binary_size = 0;
  const nlohmann::json json = checked_glb_json(content(folder / "a.glb"), binary_size);
  CHECK(json["asset"]["version"] == "2.0");
  CHECK(json["buffers"][0]["byteLength"] == binary_size);
  const nlohmann::json& primitive = json["meshes"][0]["primitives"][0];
  const std::size_t count = sample.single.size() / 3;
  for (const char* name : {"POSITION", "NORMAL", "COLOR_0"}) {
    CAPTURE(name);
    const nlohmann::json& accessor = json["accessors"][primitive["attributes"][name].get<std::size_t>()];
    CHECK(accessor["count"] == count);
    const nlohmann::json& buffer_view = json["bufferViews"][accessor["bufferView"].get<std::size_t>()];
    CHECK(buffer_view["target"] == 34962);
    CHECK(buffer_view["byteOffset"].get<std::size_t>() % 4 == 0);
    CHECK(buffer_view["byteLength"].get<std::size_t>() / count % 4 == 0);
  }
  const nlohmann::json& color = json["accessors"][primitive["attributes"]["COLOR_0"].get<std::size_t>()];
  CHECK(color["normalized"] == true);
  const nlohmann::json& position = json["accessors"][primitive["attributes"]["POSITION"].get<std::size_t>()];
  for (std::size_t k = 0; k < 3; ++k) {
    float minimum = sample.single[k], maximum = sample.single[k];
    for (std::size_t i = k; i < sample.single.size(); i += 3) {
      minimum = std::min(minimum, sample.single[i]);
      maximum = std::max(maximum, sample.single[i]);
    }
    CHECK(position["min"][k].get<float>() == minimum);
    CHECK(position["max"][k].get<float>() == maximum);
  }
  const nlohmann::json& indices = json["accessors"][primitive["indices"].get<std::size_t>()];
  CHECK(indices["count"] == sample.triangles.size());
  CHECK(indices["componentType"] == 5125);
  CHECK(json["bufferViews"][indices["bufferView"].get<std::size_t>()]["target"] == 34963);
}

TEST_CASE("write_mesh: an empty mesh is a valid file in every format", "[write]") {
  const Folder folder;
  for (const auto& [format, name] : kFormats) {
    if (format == OutputFormat::kObj) continue;  // an OBJ file without vertices is just a comment
    CAPTURE(name);
    REQUIRE(write_mesh(folder / name, MeshView(), format).message == "");
    CHECK(read_mesh(folder / name).triangle_count() == 0);
  }
  std::size_t binary_size = 0;
  const nlohmann::json json = checked_glb_json(content(folder / "a.glb"), binary_size);
  CHECK(binary_size == 0);
  CHECK_FALSE(json.contains("accessors"));
}

TEST_CASE("write_mesh: refuses spans that do not fit together", "[write]") {
  const Folder folder;
  const Sample sample;
  const std::vector<std::uint32_t> beyond = {0, 1, 256};
  const auto outcome = [&](const auto& change) {
    MeshView view = sample.view(false);
    change(view);
    return write_mesh(folder / "x.ply", view, OutputFormat::kPly).outcome;
  };
  CHECK(outcome([&](MeshView& v) { v.positions_double = sample.exact; }) == WriteOutcome::kInvalidMesh);
  CHECK(outcome([&](MeshView& v) { v.positions_single = v.positions_single.first(4); }) ==
        WriteOutcome::kInvalidMesh);
  CHECK(outcome([&](MeshView& v) { v.triangles = v.triangles.first(4); }) == WriteOutcome::kInvalidMesh);
  CHECK(outcome([&](MeshView& v) { v.triangles = beyond; }) == WriteOutcome::kInvalidMesh);
  CHECK(outcome([&](MeshView& v) { v.colors = std::span(sample.colors).first(3); }) ==
        WriteOutcome::kInvalidMesh);
  CHECK(outcome([&](MeshView& v) { v.normals = std::span(sample.normals).first(3); }) ==
        WriteOutcome::kInvalidMesh);
  CHECK(folder.file_count() == 0);
}

TEST_CASE("write_mesh: GLB refuses coordinates that JSON cannot hold", "[write][glb]") {
  const Folder folder;
  Sample sample;
  sample.single[4] = std::numeric_limits<float>::quiet_NaN();
  const WriteStatus status = write_mesh(folder / "nan.glb", sample.view(false), OutputFormat::kGlb);
  CHECK(status.outcome == WriteOutcome::kUnsupported);
  CHECK_THAT(status.message, Catch::Matchers::Contains("not finite"));
  CHECK(folder.file_count() == 0);
  REQUIRE(write_mesh(folder / "nan.ply", sample.view(false), OutputFormat::kPly).message == "");
  CHECK(std::isnan(read_mesh(folder / "nan.ply").positions[1].y));
}

TEST_CASE("write_mesh: says why it cannot write and leaves neither a part file nor a changed file",
          "[write][output]") {
  const Folder folder;
  const Sample sample;
  const WriteStatus no_folder = write_mesh(folder / "none/a.ply", sample.view(false), OutputFormat::kPly);
  CHECK(no_folder.outcome == WriteOutcome::kInputOutput);
  CHECK_THAT(no_folder.message,
             Catch::Matchers::Contains("a.ply: cannot be opened for writing: No such file"));
  if (fs::exists("/dev/full")) {
    const WriteStatus full = write_mesh("/dev/full", sample.view(false), OutputFormat::kPly);
    CHECK(full.outcome == WriteOutcome::kInputOutput);
    CHECK_THAT(full.message, Catch::Matchers::Contains("/dev/full: cannot be written: No space left"));
    CHECK(fs::is_character_file("/dev/full"));
  }
  fs::create_directory(folder / "taken.ply");
  CHECK(write_mesh(folder / "taken.ply", sample.view(false), OutputFormat::kPly).outcome ==
        WriteOutcome::kInputOutput);
  CHECK(folder.file_count() == 1);
}

TEST_CASE("write_mesh: replaces a file at once, and the target of a link", "[write][output]") {
  const Folder folder;
  const Sample sample;
  std::ofstream(folder / "old.ply") << "old";
  fs::create_symlink("old.ply", folder / "link.ply");
  REQUIRE(write_mesh(folder / "link.ply", sample.view(false), OutputFormat::kPly).message == "");
  CHECK(fs::is_symlink(folder / "link.ply"));
  CHECK(read_mesh(folder / "old.ply").vertex_count() == 256);
  CHECK(folder.file_count() == 2);
}

TEST_CASE("write_mesh: writes devices and pipes in place", "[write][output]") {
  const Folder folder;
  const Sample sample;
  REQUIRE(write_mesh("/dev/null", sample.view(false), OutputFormat::kPly).message == "");
  CHECK(fs::is_character_file("/dev/null"));
}

TEST_CASE("write_mesh: writes to standard output", "[write][output]") {
  const Folder folder;
  const Sample sample;
  const std::string piped = folder / "piped.ply", direct = folder / "direct.ply";
  std::fflush(stdout);
  const int saved = ::dup(STDOUT_FILENO);
  REQUIRE(std::freopen(piped.c_str(), "wb", stdout) != nullptr);
  const WriteStatus status = write_mesh("-", sample.view(false), OutputFormat::kPly);
  std::fflush(stdout);
  ::dup2(saved, STDOUT_FILENO);
  ::close(saved);
  CHECK(status.message == "");
  REQUIRE(write_mesh(direct, sample.view(false), OutputFormat::kPly).message == "");
  CHECK(content(piped) == content(direct));
}

TEST_CASE("output_format_from_name: knows the extensions in any case", "[write]") {
  CHECK(output_format_from_name(".PLY") == OutputFormat::kPly);
  CHECK(output_format_from_name("glb") == OutputFormat::kGlb);
  CHECK_FALSE(output_format_from_name("gltf").has_value());
  CHECK_FALSE(output_format_from_name("").has_value());
}

}  // namespace
}  // namespace nmc

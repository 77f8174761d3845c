// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "tests/unit/read/read_test_tools.h"

namespace nmc {
namespace {

namespace fs = std::filesystem;

const std::string kObjText = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
const std::string kOffText = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

class Folder {
 public:
  Folder() : path_(fs::temp_directory_path() / ("nmc-read-test-" + std::to_string(::getpid()))) {
    fs::create_directories(path_);
  }
  ~Folder() { fs::remove_all(path_); }
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(path_ / name, std::ios::binary) << text;
    return (path_ / name).string();
  }
  std::string path() const { return path_.string(); }

 private:
  fs::path path_;
};

ExitCode code_of(const std::string& path, std::string& message, const ReadOptions& options = {}) {
  try {
    read_mesh(path, options);
  } catch (const Error& error) {
    message = error.what();
    return error.code();
  }
  return ExitCode::kOk;
}

TEST_CASE("read_mesh: takes the format from the extension, the option, or the first bytes", "[read_mesh]") {
  const Folder folder;
  CHECK(read_mesh(folder.write("a.OBJ", kObjText)).triangle_count() == 1);
  CHECK(read_mesh(folder.write("b.unknown", kOffText)).triangle_count() == 1);
  ReadOptions options;
  options.format = MeshFormat::kObj;
  CHECK(read_mesh(folder.write("c.ply", kObjText), options).triangle_count() == 1);
  std::string message;
  CHECK(code_of(folder.write("d.dat", kObjText), message) == ExitCode::kUnsupported);
  CHECK_THAT(message, Catch::Matchers::Contains("d.dat: the format cannot be told"));
}

TEST_CASE("read_mesh: says why a file cannot be opened or is empty", "[read_mesh]") {
  const Folder folder;
  std::string message;
  CHECK(code_of(folder.path() + "/none.ply", message) == ExitCode::kInputOutput);
  CHECK_THAT(message, Catch::Matchers::Contains("none.ply: cannot be opened: No such file"));
  fs::create_directory(folder.path() + "/folder.ply");
  CHECK(code_of(folder.path() + "/folder.ply", message) == ExitCode::kInputOutput);
  for (const char* name : {"e.ply", "e.obj", "e.stl", "e.off", "e.gltf", "e.glb"}) {
    CHECK(code_of(folder.write(name, ""), message) == ExitCode::kInvalidInput);
    CHECK_THAT(message, Catch::Matchers::Contains("byte offset 0: the file is empty"));
  }
}

/// Runs `body` with standard input coming from a pipe that holds `text`.
template <class Body>
void with_standard_input(const std::string& text, const Body& body) {
  int ends[2];
  REQUIRE(::pipe(ends) == 0);
  REQUIRE(::write(ends[1], text.data(), text.size()) == static_cast<ssize_t>(text.size()));
  ::close(ends[1]);
  const int saved = ::dup(STDIN_FILENO);
  REQUIRE(::dup2(ends[0], STDIN_FILENO) == STDIN_FILENO);
  body();
  ::dup2(saved, STDIN_FILENO);
  ::close(saved);
  ::close(ends[0]);
}

TEST_CASE("read_mesh: reads a pipe when the format is given or its first bytes tell", "[read_mesh]") {
  ReadOptions options;
  options.format = MeshFormat::kObj;
  std::string message;
  with_standard_input(kObjText, [&] { CHECK(read_mesh("-", options).triangle_count() == 1); });
  with_standard_input(kOffText, [&] { CHECK(read_mesh("-").triangle_count() == 1); });
  with_standard_input(kObjText, [&] { CHECK(code_of("-", message) == ExitCode::kUsage); });
  CHECK_THAT(message, Catch::Matchers::StartsWith("standard input: the format cannot be told"));
  with_standard_input("OFF\n1 1\n", [&] { CHECK(code_of("-", message) == ExitCode::kInvalidInput); });
  CHECK_THAT(message, Catch::Matchers::StartsWith("standard input: line 2: "));
}

TEST_CASE("read_mesh: a glTF file finds its buffer beside it, and none elsewhere", "[read_mesh][gltf]") {
  const Folder folder;
  const auto document = [](const std::string& uri) {
    return R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":36,"uri":")" + uri +
           R"("}],"bufferViews":[{"buffer":0,"byteLength":36}],"accessors":[{"bufferView":0,"componentType":5126,)" +
           R"("count":3,"type":"VEC3"}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}]})";
  };
  folder.write("a b.bin", test::Bytes().numbers<float>({0, 0, 0, 1, 0, 0, 0, 1, 0}).string());
  CHECK(read_mesh(folder.write("m.gltf", document("a%20b.bin"))).triangle_count() == 1);
  std::string message;
  CHECK(code_of(folder.write("n.gltf", document("none.bin")), message) == ExitCode::kInputOutput);
  for (const char* uri :
       {"../x.bin", "/etc/hostname", "a/../../x.bin", "http://example.com/x.bin", "%2e%2e/x.bin", ""}) {
    CAPTURE(uri);
    CHECK(code_of(folder.write("o.gltf", document(uri)), message) == ExitCode::kUnsupported);
    CHECK_THAT(message, Catch::Matchers::Contains("buffers[0]"));
  }
  test::require_failure(MeshFormat::kGltf, document("a.bin"), ExitCode::kInputOutput,
                        "cannot be found from here");
}

}  // namespace
}  // namespace nmc

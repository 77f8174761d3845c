// SPDX-License-Identifier: Apache-2.0
// The decoder's tools as a user's script sees them: exit codes, files, JSON.
#include <sys/wait.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <utility>

#include "decoder/exit_codes.h"
#include "decoder/tool/json_writer.h"
#include "decoder/tool/quantity.h"
#include "decoder/tool/tool_error.h"
#include "encoder/core/error.h"
#include "tests/support/stream_decoding.h"
#include "tests/support/stream_generator.h"

using namespace nmc;
using namespace nmc::test;
namespace fs = std::filesystem;

namespace {

/// A folder of its own that goes away with the test.
class Scratch {
 public:
  Scratch() {
    std::string pattern = (fs::temp_directory_path() / "nmc-cli-XXXXXX").string();
    REQUIRE(mkdtemp(pattern.data()) != nullptr);
    path_ = pattern;
  }
  ~Scratch() { fs::remove_all(path_); }
  std::string file(const std::string& name) const { return (path_ / name).string(); }
  std::string write(const std::string& name, std::span<const std::uint8_t> bytes) const {
    std::ofstream out(file(name), std::ios::binary);
    out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    return file(name);
  }

 private:
  fs::path path_;
};

struct Outcome {
  int code = -1;
  std::string out, err;
};

std::string contents(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

Outcome run(const Scratch& scratch, const std::string& command) {
  const std::string out = scratch.file("stdout"), err = scratch.file("stderr");
  const int status = std::system((command + " >'" + out + "' 2>'" + err + "'").c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, contents(out), contents(err)};
}

GeneratedStream example() {
  StreamRecipe recipe;
  recipe.base = grid(4, 3, true);
  recipe.level_count = 3;
  recipe.largest_coordinate = 1000;
  return generate(recipe);
}

std::size_t vertex_count_of_ply(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::string line;
  while (std::getline(in, line) && line != "end_header") {
    if (line.rfind("element vertex ", 0) == 0) return std::stoul(line.substr(15));
  }
  return 0;
}

}  // namespace

TEST_CASE("exit codes: decoder and encoder agree", "[cli]") {
  CHECK(static_cast<int>(ToolExit::kOk) == static_cast<int>(ExitCode::kOk));
  CHECK(static_cast<int>(ToolExit::kUsage) == static_cast<int>(ExitCode::kUsage));
  CHECK(static_cast<int>(ToolExit::kInputOutput) == static_cast<int>(ExitCode::kInputOutput));
  CHECK(static_cast<int>(ToolExit::kInvalidInput) == static_cast<int>(ExitCode::kInvalidInput));
  CHECK(static_cast<int>(ToolExit::kInternal) == static_cast<int>(ExitCode::kInternal));
  CHECK(static_cast<int>(ToolExit::kUnsupported) == static_cast<int>(ExitCode::kUnsupported));
  CHECK(static_cast<int>(ToolExit::kLimit) == static_cast<int>(ExitCode::kLimit));
  CHECK(static_cast<int>(ToolExit::kTargetNotMet) == static_cast<int>(ExitCode::kTargetNotMet));
  CHECK(static_cast<int>(ToolExit::kCutOff) == static_cast<int>(ExitCode::kCutOff));
}

TEST_CASE("nmc-decode: writes every format, and only where it may", "[cli]") {
  const Scratch scratch;
  const std::string input = scratch.write("a.nmc", example().bytes);
  const std::string decode = std::string(NMC_DECODE) + " '" + input + "'";
  for (const char* extension : {"ply", "obj", "stl", "off", "glb"}) {
    const std::string output = scratch.file(std::string("m.") + extension);
    const Outcome first = run(scratch, decode + " -o '" + output + "'");
    INFO(extension << ": " << first.err);
    CHECK(first.code == 0);
    CHECK(fs::file_size(output) > 1000);
    CHECK(!fs::exists(output + ".part"));
    CHECK(run(scratch, decode + " -o '" + output + "'").code == 1);
    CHECK(run(scratch, decode + " -f -o '" + output + "'").code == 0);
  }
  CHECK(run(scratch, decode + " -o '" + scratch.file("m.xyz") + "'").code == 1);
  CHECK(run(scratch, decode).code == 0);
  CHECK(fs::exists(scratch.file("a.ply")));
  CHECK(run(scratch, decode + " -o '" + scratch.file("no/such/folder/m.ply") + "'").code == 2);
  const Outcome piped = run(scratch, std::string(NMC_DECODE) + " - -o - --format off < '" + input + "'");
  CHECK(piped.code == 0);
  CHECK(piped.out.rfind("OFF", 0) == 0);
}

TEST_CASE("nmc-decode and nmc-trim: regions", "[cli]") {
  const Scratch scratch;
  StreamRecipe recipe;
  recipe.base = grid(6, 5, true);
  recipe.level_count = 3;
  recipe.region_count = 4;
  recipe.regions_share_rows = false;
  recipe.seed = 2;
  const std::string input = scratch.write("a.nmc", generate(recipe).bytes), part = scratch.file("part.nmc");
  const std::string decode = std::string(NMC_DECODE) + " '" + input + "' ";
  const auto mesh = [&](const std::string& command, const std::string& name) {
    const Outcome outcome = run(scratch, command + " -o '" + scratch.file(name) + "'");
    INFO(command << ": " << outcome.err);
    CHECK(outcome.code == 0);
    return contents(scratch.file(name));
  };
  const std::string whole = mesh(decode, "whole.ply"), all = mesh(decode + "--regions 0,1,2,3", "all.ply"),
                    one = mesh(decode + "--regions 1", "one.ply");
  CHECK(whole == all);
  CHECK(one != whole);
  CHECK(one.size() == whole.size());
  const Outcome trimmed = run(scratch, std::string(NMC_TRIM) + " '" + input + "' -o '" + part + "' --regions 1");
  INFO(trimmed.err);
  CHECK(trimmed.code == 0);
  CHECK(fs::file_size(part) < fs::file_size(input));
  CHECK(mesh(std::string(NMC_DECODE) + " '" + part + "' ", "trimmed.ply") == one);
  CHECK(run(scratch, decode + "--no-output --regions 4").code == 1);
  CHECK(run(scratch, std::string(NMC_TRIM) + " '" + input + "' -f -o '" + part + "' --regions 4").code == 1);
  CHECK(run(scratch, std::string(NMC_TRIM) + " '" + input + "' -f -o '" + part + "'").code == 1);
  CHECK(run(scratch, std::string(NMC_INFO) + " --json '" + input + "'").out.find("\"region\":") != std::string::npos);
}

TEST_CASE("nmc-decode: level, triangles, bytes and error choose the layer", "[cli]") {
  const Scratch scratch;
  const GeneratedStream stream = example();
  const std::string input = scratch.write("a.nmc", stream.bytes), output = scratch.file("m.ply");
  const auto vertices = [&](const std::string& how) -> std::size_t {
    const Outcome outcome =
        run(scratch, std::string(NMC_DECODE) + " '" + input + "' -f -o '" + output + "' " + how);
    INFO(how << ": " << outcome.err);
    CHECK(outcome.code == 0);
    return vertex_count_of_ply(output);
  };
  CHECK(vertices("") == 12 * 64);
  CHECK(vertices("--level 0") == 12);
  CHECK(vertices("--level 2") == 12 * 16);
  CHECK(vertices("--max-triangles 100") == 48);
  CHECK(vertices("--bytes " + std::to_string(stream.layers[2].end_offset)) == 12 * 16);
  CHECK(vertices("--max-error 90%") == 12);
  const std::string decode = std::string(NMC_DECODE) + " '" + input + "' -f -o '" + output + "' ";
  CHECK(run(scratch, decode + "--level 4").code == 1);
  CHECK(run(scratch, decode + "--level 1 --bytes 10").code == 1);
  CHECK(run(scratch, decode + "--max-triangles 5").code == 7);
  CHECK(run(scratch, decode + "--bytes 20").code == 7);
  CHECK(run(scratch, decode + "--max-error 0.0001%").code == 7);
  CHECK(run(scratch, decode + "--max-error 3parsec").code == 1);
  CHECK(run(scratch, decode + "--max-alloc 100kB").code == 6);
  CHECK(run(scratch, decode + "--max-triangles-limit 100").code == 6);
}

TEST_CASE("nmc-decode: adaptive output has fewer triangles, says how far it is off, and has no cracks",
          "[cli]") {
  const Scratch scratch;
  const std::string input = scratch.write("a.nmc", example().bytes), output = scratch.file("m.off");
  const auto triangles = [&](const std::string& how) -> std::size_t {
    const Outcome outcome =
        run(scratch, std::string(NMC_DECODE) + " '" + input + "' -f -o '" + output + "' " + how);
    INFO(how << ": " << outcome.err);
    CHECK(outcome.code == 0);
    std::istringstream text(contents(output));
    std::string off;
    std::size_t vertex_count = 0, face_count = 0, edge_count = 0;
    text >> off >> vertex_count >> face_count >> edge_count;
    double skipped = 0;
    for (std::size_t i = 0; i < 3 * vertex_count; ++i) text >> skipped;
    std::map<std::pair<std::size_t, std::size_t>, int> balance;
    for (std::size_t f = 0; f < face_count; ++f) {
      std::size_t size = 0, v[3] = {};
      text >> size >> v[0] >> v[1] >> v[2];
      for (std::size_t k = 0; k < 3; ++k) {
        ++balance[{v[k], v[(k + 1) % 3]}];
        --balance[{v[(k + 1) % 3], v[k]}];
      }
    }
    std::size_t open_edges = 0;
    for (const auto& [edge, sum] : balance) open_edges += sum != 0;
    CHECK(open_edges == 0);
    return face_count;
  };
  CHECK(triangles("--adaptive 0") == 24 * 64);
  const std::size_t some = triangles("--adaptive 0.01%"), few = triangles("--adaptive 0.03%");
  CHECK(some < 24 * 64);
  CHECK(few < some);
  CHECK(triangles("--adaptive 60% --level 1") <= 24 * 4);
  const std::string decode = std::string(NMC_DECODE) + " '" + input + "' -f -o '" + output + "' ";
  CHECK(run(scratch, decode + "--adaptive 5% --normals vertex").err.find("for adaptivity") !=
        std::string::npos);
  CHECK(run(scratch, decode + "--adaptive -1").code == 1);
  CHECK(run(scratch, decode + "--adaptive 1parsec").code == 1);
}

TEST_CASE("nmc-decode: base mesh and displacement image", "[cli]") {
  const Scratch scratch;
  const std::string input = scratch.write("a.nmc", example().bytes), prefix = scratch.file("base");
  const std::string decode =
      std::string(NMC_DECODE) + " '" + input + "' --base-and-displacement '" + prefix + "'";
  const Outcome first = run(scratch, decode);
  INFO(first.err);
  CHECK(first.code == 0);
  CHECK(first.err.find("24 base triangles") != std::string::npos);
  const std::string object = contents(prefix + ".obj");
  CHECK(std::count(object.begin(), object.end(), '\n') == 3 + 12 + 72 + 24);
  // 24 tiles of 9 texels, five beside each other.
  CHECK(fs::file_size(prefix + ".exr") > std::size_t{45} * 45 * 12);
  CHECK(run(scratch, decode).code == 1);
  CHECK(run(scratch, decode + " -f --level 1").code == 0);
  CHECK(fs::file_size(prefix + ".exr") < std::size_t{45} * 45 * 12);
  CHECK(run(scratch, decode + " -f --adaptive 1%").code == 1);
  CHECK(run(scratch, decode + " -f -o x.ply").code == 1);
}

TEST_CASE("nmc-decode: cut-off and damaged files", "[cli]") {
  const Scratch scratch;
  const GeneratedStream stream = example();
  const std::size_t cut_size = stream.layers[2].end_offset + 3;
  const std::string cut = scratch.write("cut.nmc", {stream.bytes.data(), cut_size});
  const std::string output = scratch.file("m.ply");
  const Outcome plain = run(scratch, std::string(NMC_DECODE) + " '" + cut + "' -o '" + output + "'");
  INFO(plain.err);
  CHECK(plain.code == 8);
  CHECK(vertex_count_of_ply(output) == 12 * 16);
  CHECK(plain.err.find("3 of 4 layers") != std::string::npos);
  CHECK(
      run(scratch, std::string(NMC_DECODE) + " '" + cut + "' -f -o '" + output + "' --allow-partial").code ==
      0);

  std::vector<std::uint8_t> damaged_bytes = stream.bytes;
  damaged_bytes[cut_size] ^= 1;
  const std::string damaged = scratch.write("damaged.nmc", damaged_bytes), other = scratch.file("n.ply");
  const Outcome refused = run(scratch, std::string(NMC_DECODE) + " '" + damaged + "' -o '" + other + "'");
  INFO(refused.err);
  CHECK(refused.code == 3);
  CHECK(!fs::exists(other));
  CHECK(refused.err.find("section 3.2") != std::string::npos);
  CHECK(
      run(scratch, std::string(NMC_DECODE) + " '" + damaged + "' -o '" + other + "' --allow-partial").code ==
      0);
  CHECK(vertex_count_of_ply(other) == 12 * 16);

  const std::string nothing = scratch.write("nothing.nmc", {});
  CHECK(run(scratch, std::string(NMC_DECODE) + " '" + nothing + "' --no-output --hash").code == 3);
  CHECK(run(scratch, std::string(NMC_DECODE) + " '" + scratch.file("missing.nmc") + "'").code == 2);
}

TEST_CASE("nmc-info: JSON for sound and broken files alike, hashes as in the stream", "[cli]") {
  const Scratch scratch;
  const GeneratedStream stream = example();
  const std::string good = scratch.write("a \"b\".nmc", stream.bytes);
  const Outcome outcome = run(scratch, std::string(NMC_INFO) + " --json=mini --hash '" + good + "'");
  INFO(outcome.out << outcome.err);
  CHECK(outcome.code == 0);
  CHECK(outcome.out.rfind("{\"schema\":\"nmc-info-v1\",", 0) == 0);
  CHECK(outcome.out.find("\"valid\":true") != std::string::npos);
  CHECK(outcome.out.find("a \\\"b\\\".nmc") != std::string::npos);
  for (const ExpectedLayer& layer : stream.layers) {
    CHECK(outcome.out.find(hash_text(layer.state_hash)) != std::string::npos);
    CHECK(outcome.out.find(hash_text(layer.position_hash)) != std::string::npos);
  }
  const std::string cut = scratch.write("cut.nmc", {stream.bytes.data(), stream.bytes.size() - 1});
  const Outcome broken = run(scratch, std::string(NMC_INFO) + " --json=mini '" + cut + "'");
  CHECK(broken.code == 8);
  CHECK(broken.out.find("\"status\":\"NMC_ERR_TRUNCATED\"") != std::string::npos);
  CHECK(run(scratch, std::string(NMC_INFO) + " --json '" + scratch.file("missing") + "'").code == 2);
  CHECK(run(scratch, std::string(NMC_INFO) + " --test --layers '" + good + "'").code == 0);
  CHECK(run(scratch, std::string(NMC_INFO) + " --test '" + cut + "'").code == 8);
  CHECK(run(scratch, std::string(NMC_INFO) + " --no-such-flag '" + good + "'").code == 1);
}

TEST_CASE("nmc-trim: what is left is a whole stream with the same meshes", "[cli]") {
  const Scratch scratch;
  const GeneratedStream stream = example();
  const std::string input = scratch.write("a.nmc", stream.bytes), output = scratch.file("t.nmc");
  const std::string trim = std::string(NMC_TRIM) + " '" + input + "' -f -o '" + output + "' ";
  const auto layers_after = [&](const std::string& how) -> std::size_t {
    const Outcome outcome = run(scratch, trim + how);
    INFO(how << ": " << outcome.err);
    CHECK(outcome.code == 0);
    const std::string text = contents(output);
    const Decoding decoding = decode({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
    INFO(decoding);
    CHECK(decoding.status == NMC_OK);
    for (std::size_t i = 0; i < decoding.layers.size(); ++i) {
      CHECK(decoding.layers[i].state_hash == stream.layers[i].state_hash);
      CHECK(decoding.layers[i].position_hash == stream.layers[i].position_hash);
    }
    return decoding.layers.size();
  };
  CHECK(layers_after("--level 1") == 2);
  CHECK(layers_after("--max-triangles 24") == 1);
  CHECK(layers_after("--max-error 90%") == 1);
  const std::size_t size = stream.layers[2].end_offset;
  CHECK(layers_after("--size " + std::to_string(size)) == 3);
  CHECK(fs::file_size(output) <= size);
  CHECK(layers_after("--size 1GB") == 4);
  CHECK(run(scratch, trim + "--size 30").code == 7);
  CHECK(run(scratch, trim + "--max-error 0.0001%").code == 7);
  CHECK(run(scratch, trim).code == 1);
}

TEST_CASE("json writer: any bytes become valid ASCII strings", "[cli]") {
  JsonWriter json(true);
  json.begin('[');
  json.value(std::string_view("a\"\\\n\x1b\xff\xc3\xa4\xed\xa0\x80\xf0\x9f\x98\x80", 15));
  json.value(1.5);
  json.value(1.0 / 0.0);
  json.end(']');
  CHECK(json.text() ==
        "[\"a\\\"\\\\\\u000a\\u001b\\ufffd\\u00e4\\ufffd\\ufffd\\ufffd\\ud83d\\ude00\",1.5,null]");
}

TEST_CASE("quantities: sizes and lengths with units", "[cli]") {
  CHECK(parse_size("1.5MiB") == 1572864);
  CHECK(parse_size("20kB") == 20000);
  CHECK_THROWS_AS(parse_size("20 kB"), ToolError);
  CHECK_THROWS_AS(parse_size("-3"), ToolError);
  nmc_info info{};
  info.diagonal = 50;
  CHECK(parse_length("2%", info) == Approx(1));
  CHECK_THROWS_AS(parse_length("1mm", info), ToolError);
  info.units = NMC_UNITS_CENTIMETRE;
  CHECK(parse_length("1mm", info) == Approx(0.1));
  CHECK(parse_length("1in", info) == Approx(2.54));
  CHECK(bytes_text(999) == "999 bytes");
  CHECK(bytes_text(2481133) == "2.48 MB");
}

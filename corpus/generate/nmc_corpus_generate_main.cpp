// SPDX-License-Identifier: Apache-2.0
// nmc-corpus-generate: generated meshes, bad inputs, and large versions of real scans, as files.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>

#include "corpus/generate/bad_inputs.h"
#include "corpus/generate/shapes.h"
#include "decoder/write/mesh_writer.h"
#include "encoder/core/error.h"
#include "encoder/read/mesh_reader.h"

namespace {

void write(const std::string& path, const nmc::TriangleMesh& mesh) {
  static_assert(sizeof(nmc::Vec3) == 3 * sizeof(double));
  nmc::MeshView view;
  view.positions_double = {&mesh.positions[0].x, 3 * mesh.vertex_count()};
  view.triangles = {mesh.triangles[0].data(), 3 * mesh.triangle_count()};
  const auto format = nmc::output_format_from_name(std::filesystem::path(path).extension().string());
  if (!format)
    throw nmc::Error(nmc::ExitCode::kUsage,
                     fmt::format("{}: not a name of a PLY, OBJ, STL, OFF or GLB file", path));
  const nmc::WriteStatus status = nmc::write_mesh(path, view, *format);
  if (!status.is_ok()) throw nmc::Error(nmc::ExitCode::kInputOutput, status.message);
  fmt::print("{}: {} vertices, {} triangles\n", path, mesh.vertex_count(), mesh.triangle_count());
}

void write_text(const std::string& path, const std::string& text) {
  std::FILE* file = std::fopen(path.c_str(), "wb");
  const bool written = file != nullptr && std::fwrite(text.data(), 1, text.size(), file) == text.size();
  const bool closed = file != nullptr && std::fclose(file) == 0;
  if (!written || !closed) throw nmc::Error(nmc::ExitCode::kInputOutput, path + ": cannot be written");
  fmt::print("{}: {} bytes\n", path, text.size());
}

struct Arguments {
  std::string folder, input, output;
  std::vector<std::string> names;
  std::size_t triangle_count = 0;
  double noise = 2e-4;
  std::uint64_t seed = 4;
};

void write_shapes(const Arguments& arguments) {
  std::filesystem::create_directories(arguments.folder);
  std::vector<std::string> missing = arguments.names;
  for (const nmc::corpus::CatalogueEntry& entry : nmc::corpus::catalogue()) {
    const bool is_named = std::erase(missing, entry.name) > 0;
    if (is_named || arguments.names.empty())
      write(arguments.folder + "/" + entry.name + ".ply", entry.make());
  }
  if (!missing.empty())
    throw nmc::Error(nmc::ExitCode::kUsage, fmt::format("there is no shape \"{}\"; try: list", missing[0]));
}

void write_bad_inputs(const Arguments& arguments) {
  std::filesystem::create_directories(arguments.folder);
  std::string expected = "name,exit_code\n";
  for (const nmc::corpus::BadInput& input : nmc::corpus::bad_inputs()) {
    write_text(arguments.folder + "/" + input.name + ".ply", ply_text(input));
    expected += fmt::format("{},{}\n", input.name, input.expected == nmc::corpus::Expected::kEncoded ? 0 : 3);
  }
  write_text(arguments.folder + "/expected.csv", expected);
}

void list_shapes() {
  for (const nmc::corpus::CatalogueEntry& entry : nmc::corpus::catalogue())
    fmt::print("{:<18} {}\n", entry.name, entry.why);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Writes generated meshes. Deterministic: the same arguments give the same bytes.");
  app.require_subcommand(1);
  Arguments arguments;
  CLI::App* list = app.add_subcommand("list", "names of the generated shapes, and what each is hard for");
  CLI::App* shapes = app.add_subcommand("shapes", "write generated shapes as PLY");
  shapes->add_option("FOLDER", arguments.folder, "where to")->required();
  shapes->add_option("NAME", arguments.names, "only these shapes (default: all)");
  CLI::App* bad =
      app.add_subcommand("bad-inputs", "write defective PLY files and expected.csv with exit codes");
  bad->add_option("FOLDER", arguments.folder, "where to")->required();
  CLI::App* subdivide =
      app.add_subcommand("subdivide", "subdivide a mesh to a number of triangles and add noise");
  subdivide->add_option("INPUT", arguments.input, "mesh file")->required();
  subdivide->add_option("OUTPUT", arguments.output, "mesh file (.ply, .obj, .stl, .off, .glb)")->required();
  subdivide->add_option("--triangles", arguments.triangle_count, "at least so many triangles")->required();
  subdivide->add_option("--noise", arguments.noise, "standard deviation along the normals, of the diagonal")
      ->capture_default_str();
  subdivide->add_option("--seed", arguments.seed, "of the noise")->capture_default_str();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : static_cast<int>(nmc::ExitCode::kUsage);
  }
  try {
    if (*list) list_shapes();
    if (*shapes) write_shapes(arguments);
    if (*bad) write_bad_inputs(arguments);
    if (*subdivide)
      write(arguments.output,
            nmc::corpus::subdivide(nmc::read_mesh(arguments.input), arguments.triangle_count, arguments.noise,
                                   arguments.seed));
    return 0;
  } catch (const nmc::Error& error) {
    fmt::print(stderr, "nmc-corpus-generate: {}\n", error.what());
    return static_cast<int>(error.code());
  } catch (const std::exception& error) {
    fmt::print(stderr, "nmc-corpus-generate: {}\n", error.what());
    return static_cast<int>(nmc::ExitCode::kInternal);
  }
}

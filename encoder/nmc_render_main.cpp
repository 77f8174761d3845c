// SPDX-License-Identifier: Apache-2.0
// nmc-render: a picture of an original, a result, and the distance between them. No display and no GPU
// needed.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>

#include "encoder/core/error.h"
#include "encoder/measure/compare_meshes.h"
#include "encoder/measure/stream_layers.h"
#include "encoder/read/mesh_reader.h"
#include "encoder/render/comparison_picture.h"

namespace {

struct Arguments {
  std::string original, result, output;
  nmc::PictureOptions picture;
  std::vector<double> view_from, up;
};

void run(Arguments& arguments) {
  const nmc::TriangleMesh original = nmc::read_mesh(arguments.original);
  const nmc::TriangleMesh result = nmc::is_stream_name(arguments.result) ? nmc::read_stream(arguments.result)
                                                                         : nmc::read_mesh(arguments.result);
  const nmc::CompareResult compared = compare_meshes(original, result);
  if (arguments.view_from.size() == 3) {
    arguments.picture.view_from =
        nmc::Vec3{arguments.view_from[0], arguments.view_from[1], arguments.view_from[2]};
  }
  if (arguments.up.size() == 3) arguments.picture.up = {arguments.up[0], arguments.up[1], arguments.up[2]};
  arguments.picture.original_title = std::filesystem::path(arguments.original).filename().string();
  arguments.picture.result_title = std::filesystem::path(arguments.result).filename().string();
  write_png(arguments.output, comparison_picture(original, result, compared, arguments.picture));
  fmt::print("{}: RMS {:.6g} ({:.4f} % of the diagonal), max {:.6g}\n", arguments.output, compared.rms,
             100 * compared.relative_rms(), compared.maximum);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "Draws ORIGINAL and RESULT beside each other, and RESULT coloured by its distance to ORIGINAL, as "
      "PNG.");
  Arguments arguments;
  app.add_option("--original", arguments.original, "mesh file (PLY, OBJ, STL, OFF, glTF, GLB)")->required();
  app.add_option("--result", arguments.result, "mesh file, or a .nmc stream")->required();
  app.add_option("-o,--output", arguments.output, "the picture (.png)")->required();
  app.add_option("--size", arguments.picture.panel_size, "pixels of each of the three square panels")
      ->check(CLI::Range(100, 4000))
      ->capture_default_str();
  app.add_option("--view", arguments.view_from, "direction from the object to the eye: X Y Z")->expected(3);
  app.add_option("--up", arguments.up, "direction that is up: X Y Z (default 0 1 0)")->expected(3);
  app.add_option("--scale-end", arguments.picture.scale_end,
                 "distance at the end of the colour scale, in units");
  app.add_flag("!--no-colour,!--no-color", arguments.picture.shows_colors,
               "show the shape alone, without the colours of the surfaces");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : static_cast<int>(nmc::ExitCode::kUsage);
  }
  try {
    run(arguments);
  } catch (const nmc::Error& error) {
    fmt::print(stderr, "nmc-render: {}\n", error.what());
    return static_cast<int>(error.code());
  } catch (const std::exception& error) {
    fmt::print(stderr, "nmc-render: internal error: {}\n", error.what());
    return static_cast<int>(nmc::ExitCode::kInternal);
  }
  return 0;
}

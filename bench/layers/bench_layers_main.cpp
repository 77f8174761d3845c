// SPDX-License-Identifier: Apache-2.0
// nmc-bench-layers MESH --rms-error 0.01%: what one file for all rates costs.
//
// Encodes the mesh once with several quality layers and, for comparison, with one layer at several sizes. The
// layered file is then cut at sizes in equal ratios: what a cut leaves is the last complete row of the layer
// table. Printed is how much larger its error is than that of a single-layer file of the same size, in dB;
// between the single-layer files' sizes their errors are interpolated in logarithms. Cuts at the ends of rows
// are printed too: they do not depend on where the sizes fall.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "encoder/core/error.h"
#include "encoder/pipeline/encode_mesh.h"
#include "encoder/read/mesh_reader.h"

namespace {

struct Point {
  double bytes = 0, rms = 0;
};

/// The error of a single-layer file of `bytes`; beyond the ends the outermost pair is continued.
double single_layer_rms(const std::vector<Point>& files, double bytes) {
  std::size_t i = 0;
  while (i + 2 < files.size() && files[i + 1].bytes < bytes) ++i;
  const double share = std::log(bytes / files[i].bytes) / std::log(files[i + 1].bytes / files[i].bytes);
  return files[i].rms * std::pow(files[i + 1].rms / files[i].rms, share);
}

double loss_in_decibels(const std::vector<Point>& files, double bytes, double rms) {
  return 20 * std::log10(rms / single_layer_rms(files, bytes));
}

struct Arguments {
  std::string mesh;
  double rms_error = 1e-4;  // over the diagonal
  int layer_count = 3, point_count = 12, file_count = 5, effort = 1;
  double smallest_share = 0.25;
  int base_vertex_count = 0, level_count = 0, region_count = 0;
};

void run(const Arguments& arguments) {
  const nmc::TriangleMesh input = nmc::read_mesh(arguments.mesh);
  nmc::EncodeOptions options;
  options.effort = arguments.effort;
  if (arguments.base_vertex_count > 0) options.base_vertex_count = arguments.base_vertex_count;
  if (arguments.level_count > 0) options.level_count = arguments.level_count;
  const double diagonal = nmc::measurable_box(input).diagonal();
  options.target = {nmc::TargetKind::kRmsError, arguments.rms_error * diagonal};
  options.quality_layer_count = arguments.layer_count;
  options.region_count = arguments.region_count;
  const nmc::EncodeResult layered = nmc::encode_mesh(input, options);
  const auto full = static_cast<double>(layered.stream.bytes.size());
  fmt::print("{} layers: {} bytes, RMS {:.3e} of the diagonal\n", arguments.layer_count, full,
             layered.error.rms / diagonal);

  options.quality_layer_count = 1;
  options.region_count = 0;
  std::vector<Point> files;
  for (int i = 0; i < arguments.file_count; ++i) {
    const double share = std::pow(arguments.smallest_share, 1 - i / (arguments.file_count - 1.0));
    options.target = {nmc::TargetKind::kSize, std::round(full * share)};
    const nmc::EncodeResult single = nmc::encode_mesh(input, options);
    files.push_back({static_cast<double>(single.stream.bytes.size()), single.error.rms / diagonal});
    fmt::print("one layer: {} bytes, RMS {:.3e}\n", files.back().bytes, files.back().rms);
    std::fflush(stdout);
  }

  fmt::print("\nrow ends: bytes, level, RMS, loss in dB\n");
  for (const nmc::StreamRow& row : layered.stream.rows) {
    fmt::print("{:>8} {:>2} {:.3e} {:>6.2f}\n", row.end_offset, row.level, row.error.rms / diagonal,
               loss_in_decibels(files, static_cast<double>(row.end_offset), row.error.rms / diagonal));
  }
  fmt::print("\ncuts: bytes, bytes left, RMS, loss in dB\n");
  double sum = 0, largest = 0;
  for (int i = 0; i < arguments.point_count; ++i) {
    const double size = full * std::pow(arguments.smallest_share, 1 - (i + 1.0) / arguments.point_count);
    const nmc::StreamRow* left = nullptr;
    for (const nmc::StreamRow& row : layered.stream.rows)
      if (static_cast<double>(row.end_offset) <= size + 0.5) left = &row;
    if (!left) {
      fmt::print("{:>8.0f}  nothing to show\n", size);
      continue;
    }
    const double loss = loss_in_decibels(files, size, left->error.rms / diagonal);
    sum += loss;
    largest = std::max(largest, loss);
    fmt::print("{:>8.0f} {:>8} {:.3e} {:>6.2f}\n", size, left->end_offset, left->error.rms / diagonal, loss);
  }
  fmt::print("mean {:.2f} dB, largest {:.2f} dB\n", sum / arguments.point_count, largest);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Loss of one layered file, cut at many sizes, against files of one layer.");
  Arguments arguments;
  app.add_option("mesh", arguments.mesh, "input mesh")->required();
  app.add_option("--rms-error", arguments.rms_error, "of the whole file, over the diagonal")
      ->capture_default_str();
  app.add_option("--layers", arguments.layer_count, "quality layers")->capture_default_str();
  app.add_option("--points", arguments.point_count, "sizes to cut at")->capture_default_str();
  app.add_option("--files", arguments.file_count, "single-layer files to compare with")
      ->capture_default_str();
  app.add_option("--smallest", arguments.smallest_share, "smallest cut over the whole file")
      ->capture_default_str();
  app.add_option("--effort", arguments.effort, "of all encodes")->capture_default_str();
  app.add_option("--base", arguments.base_vertex_count, "base vertices of all encodes; 0: chosen");
  app.add_option("--levels", arguments.level_count, "levels of all encodes; 0: chosen");
  app.add_option("--regions", arguments.region_count, "regions of the layered file");
  CLI11_PARSE(app, argc, argv);
  try {
    run(arguments);
  } catch (const nmc::Error& error) {
    fmt::print(stderr, "nmc-bench-layers: {}\n", error.what());
    return static_cast<int>(error.code());
  }
  return 0;
}

// SPDX-License-Identifier: Apache-2.0
// nmc-compare: how far two surfaces are apart. A thin front of encoder/measure/compare_meshes.h.
#include <fmt/core.h>
#include <oneapi/tbb/global_control.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "decoder/write/mesh_writer.h"
#include "encoder/core/error.h"
#include "encoder/measure/color_ramp.h"
#include "encoder/measure/compare_meshes.h"
#include "encoder/measure/stream_layers.h"
#include "encoder/read/mesh_reader.h"
#include "encoder/render/comparison_picture.h"

namespace {

using nmc::CompareResult;
using nmc::OneSidedDistance;
using nmc::TriangleMesh;

struct Arguments {
  std::string original, result;
  bool json = false;
  bool mpeg = false;
  bool layers = false;
  std::size_t samples = 0;
  std::size_t threads = 0;
  std::string heatmap;
  double heatmap_end = 0;
};

nlohmann::ordered_json to_json(const OneSidedDistance& side, double diagonal) {
  return {{"rms", side.rms},
          {"mean", side.mean},
          {"max", side.maximum},
          {"maxAt", {side.maximum_at.x, side.maximum_at.y, side.maximum_at.z}},
          {"relativeRms", side.rms / diagonal},
          {"relativeMax", side.maximum / diagonal},
          {"normalMeanDegrees", side.normal_mean_degrees},
          {"normalRmsDegrees", side.normal_rms_degrees},
          {"samples", side.sample_count},
          {"vertices", side.vertex_count}};
}

// JSON knows no infinity: equal surfaces have no PSNR.
nlohmann::ordered_json finite_or_null(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json();
}

void print_json(const Arguments& arguments, const TriangleMesh& original, const TriangleMesh& result,
                const CompareResult& compared) {
  nlohmann::ordered_json report = {
      {"schema", "nmc-compare-v1"},
      {"original",
       {{"file", arguments.original},
        {"vertices", original.vertex_count()},
        {"triangles", original.triangle_count()}}},
      {"result",
       {{"file", arguments.result},
        {"vertices", result.vertex_count()},
        {"triangles", result.triangle_count()}}},
      {"diagonal", compared.diagonal},
      {"rms", compared.rms},
      {"mean", compared.mean},
      {"max", compared.maximum},
      {"relativeRms", finite_or_null(compared.relative_rms())},
      {"relativeMean", finite_or_null(compared.relative_mean())},
      {"relativeMax", finite_or_null(compared.relative_maximum())},
      {"psnrDb", finite_or_null(compared.psnr_db())},
      {"normalMeanDegrees", compared.normal_mean_degrees},
      {"normalRmsDegrees", compared.normal_rms_degrees},
      {"orientationReversed", compared.orientation_reversed},
      {"originalToResult", to_json(compared.original_to_result, compared.diagonal)},
      {"resultToOriginal", to_json(compared.result_to_original, compared.diagonal)}};
  if (compared.original_volume && compared.result_volume) {
    report["originalVolume"] = *compared.original_volume;
    report["resultVolume"] = *compared.result_volume;
  }
  if (compared.rgb_psnr_db) {
    report["lumaPsnrDb"] = finite_or_null(*compared.luma_psnr_db);
    report["rgbPsnrDb"] = finite_or_null(*compared.rgb_psnr_db);
  }
  if (compared.mpeg) {
    report["mpegD1Db"] = finite_or_null(compared.mpeg->point_to_point_db);
    report["mpegD2Db"] = finite_or_null(compared.mpeg->point_to_plane_db);
  }
  fmt::print("{}\n", report.dump(2));
}

void print_text(const TriangleMesh& original, const TriangleMesh& result, const CompareResult& compared) {
  const auto line = [&](const char* name, double symmetric, double forward, double backward) {
    fmt::print("{:<10} {:<13.6g} {:<12.4e} {:<13.6g} {:<13.6g}\n", name, symmetric,
               symmetric / compared.diagonal, forward, backward);
  };
  const OneSidedDistance& forward = compared.original_to_result;
  const OneSidedDistance& backward = compared.result_to_original;
  fmt::print("original   {} vertices, {} triangles, diagonal {:.6g}\n", original.vertex_count(),
             original.triangle_count(), compared.diagonal);
  fmt::print("result     {} vertices, {} triangles\n", result.vertex_count(), result.triangle_count());
  fmt::print("distance   in units      of diagonal  from original from result\n");
  line("RMS", compared.rms, forward.rms, backward.rms);
  line("mean", compared.mean, forward.mean, backward.mean);
  line("max", compared.maximum, forward.maximum, backward.maximum);
  fmt::print("PSNR       {:.2f} dB\n", compared.psnr_db());
  fmt::print("normals    {:.3f} degrees mean, {:.3f} RMS{}\n", compared.normal_mean_degrees,
             compared.normal_rms_degrees,
             compared.orientation_reversed ? " (the result is turned inside out)" : "");
  if (compared.original_volume && compared.result_volume) {
    fmt::print("volume     {:.6g} and {:.6g} ({:+.4f} %)\n", *compared.original_volume,
               *compared.result_volume,
               100 * (std::abs(*compared.result_volume / *compared.original_volume) - 1));
  }
  if (compared.rgb_psnr_db) {
    fmt::print("colour     {:.2f} dB luma, {:.2f} dB RGB\n", *compared.luma_psnr_db, *compared.rgb_psnr_db);
  }
  if (compared.mpeg) {
    fmt::print("MPEG       D1 {:.2f} dB, D2 {:.2f} dB\n", compared.mpeg->point_to_point_db,
               compared.mpeg->point_to_plane_db);
  }
}

bool ends_with(const std::string& text, std::string_view end) {
  return text.size() >= end.size() && std::string_view(text).substr(text.size() - end.size()) == end;
}

// The result with every vertex coloured by its distance to the original.
void write_heatmap_mesh(const std::string& path, const TriangleMesh& original, const TriangleMesh& result,
                        double scale_end) {
  const std::vector<double> distances = vertex_distances(result, nmc::SurfaceIndex(original));
  std::vector<std::uint8_t> colors;
  std::vector<double> positions;
  for (std::size_t v = 0; v < result.vertex_count(); ++v) {
    const nmc::RgbColor color = nmc::ramp_color(distances[v] / scale_end);
    colors.insert(colors.end(), color.begin(), color.end());
    for (int i = 0; i < 3; ++i) positions.push_back(result.positions[v][i]);
  }
  std::vector<std::uint32_t> triangles;
  for (const nmc::Triangle& triangle : result.triangles)
    triangles.insert(triangles.end(), triangle.begin(), triangle.end());
  nmc::MeshView view;
  view.positions_double = positions;
  view.triangles = triangles;
  view.colors = colors;
  const nmc::WriteStatus status = write_mesh(path, view, nmc::OutputFormat::kPly);
  if (!status.is_ok()) throw nmc::Error(nmc::ExitCode::kInputOutput, status.message);
}

void write_heatmap(const Arguments& arguments, const TriangleMesh& original, const TriangleMesh& result,
                   const CompareResult& compared) {
  const double scale_end =
      arguments.heatmap_end > 0 ? arguments.heatmap_end : nmc::round_scale_end(3 * compared.rms);
  if (ends_with(arguments.heatmap, ".png")) {
    nmc::PictureOptions options;
    options.scale_end = scale_end;
    write_png(arguments.heatmap, comparison_picture(original, result, compared, options));
  } else {
    write_heatmap_mesh(arguments.heatmap, original, result, scale_end);
  }
}

TriangleMesh read_surface(const std::string& path) {
  return nmc::is_stream_name(path) ? nmc::read_stream(path) : nmc::read_mesh(path);
}

// One row for each layer of the stream: what the bytes up to its end give, as measured and as the stream
// states it.
void compare_layers(const Arguments& arguments) {
  if (!nmc::is_stream_name(arguments.result)) {
    throw nmc::Error(nmc::ExitCode::kUsage, arguments.result + ": --layers needs a .nmc stream as RESULT");
  }
  const TriangleMesh original = read_surface(arguments.original);
  const nmc::SurfaceIndex index(original);
  nmc::CompareOptions options;
  options.sample_count = arguments.samples;
  options.original_index = &index;
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  if (!arguments.json)
    fmt::print("     bytes level  triangles          RMS          max   stated RMS   stated max\n");
  nmc::visit_stream_layers(arguments.result, [&](const nmc::StreamLayer& layer, const TriangleMesh& mesh) {
    const CompareResult compared = compare_meshes(original, mesh, options);
    if (arguments.json) {
      nlohmann::ordered_json row = {{"endByte", layer.end_byte},
                                    {"level", layer.level},
                                    {"triangles", mesh.triangle_count()},
                                    {"rms", compared.rms},
                                    {"max", compared.maximum},
                                    {"relativeRms", finite_or_null(compared.relative_rms())},
                                    {"relativeMax", finite_or_null(compared.relative_maximum())},
                                    {"normalMeanDegrees", compared.normal_mean_degrees}};
      if (layer.states_error) {
        row["statedRms"] = layer.stated_rms;
        row["statedMax"] = layer.stated_maximum;
      }
      rows.push_back(row);
      return;
    }
    const auto stated = [&](double value) {
      return layer.states_error ? fmt::format("{:12.6g}", value) : "            -";
    };
    fmt::print("{:10} {:5} {:10} {:12.6g} {:12.6g} {} {}\n", layer.end_byte, layer.level,
               mesh.triangle_count(), compared.rms, compared.maximum, stated(layer.stated_rms),
               stated(layer.stated_maximum));
  });
  if (arguments.json) {
    const nlohmann::ordered_json report = {{"schema", "nmc-compare-layers-v1"},
                                           {"original", arguments.original},
                                           {"result", arguments.result},
                                           {"diagonal", bounding_box(original).diagonal()},
                                           {"layers", rows}};
    fmt::print("{}\n", report.dump(2));
  }
}

void run(const Arguments& arguments) {
  if (arguments.layers) return compare_layers(arguments);
  if (!arguments.heatmap.empty() && !ends_with(arguments.heatmap, ".png") &&
      !ends_with(arguments.heatmap, ".ply")) {
    throw nmc::Error(nmc::ExitCode::kUsage, arguments.heatmap + ": a heatmap is a .ply or a .png file");
  }
  const TriangleMesh original = read_surface(arguments.original);
  const TriangleMesh result = read_surface(arguments.result);
  nmc::CompareOptions options;
  options.sample_count = arguments.samples;
  options.mpeg_grid = arguments.mpeg ? 1024 : 0;
  const CompareResult compared = compare_meshes(original, result, options);
  if (arguments.json) {
    print_json(arguments, original, result, compared);
  } else {
    print_text(original, result, compared);
  }
  if (!arguments.heatmap.empty()) write_heatmap(arguments, original, result, compared);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "Measures how far the surface RESULT is from the surface ORIGINAL, both ways: RMS, mean and largest "
      "distance\n"
      "(area-uniform points; the largest also over all vertices), angles of the normals, volumes, colours.");
  Arguments arguments;
  app.add_option("ORIGINAL", arguments.original,
                 "mesh file (PLY, OBJ, STL, OFF, glTF, GLB); distances are relative to it")
      ->required();
  app.add_option("RESULT", arguments.result, "mesh file, or a .nmc stream")->required();
  app.add_flag("--json", arguments.json, "print JSON (schema nmc-compare-v1)");
  app.add_option("--samples", arguments.samples,
                 "points per direction (default: the larger of 200000 and twice the triangles)");
  app.add_flag("--layers", arguments.layers, "RESULT is a stream: measure the mesh of each of its prefixes");
  app.add_flag("--mpeg", arguments.mpeg, "also MPEG's D1 and D2, sampled on a grid of 1024 lines");
  app.add_option("--heatmap", arguments.heatmap,
                 "write RESULT coloured by its distance to ORIGINAL (.ply), or a picture of both (.png)");
  app.add_option("--heatmap-end", arguments.heatmap_end,
                 "distance at the end of the colour scale, in units (default: about three times the RMS)");
  app.add_option("--threads", arguments.threads, "number of threads (default: all processors)");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : static_cast<int>(nmc::ExitCode::kUsage);
  }
  try {
    std::optional<oneapi::tbb::global_control> limit;
    if (arguments.threads != 0) {
      limit.emplace(oneapi::tbb::global_control::max_allowed_parallelism, arguments.threads);
    }
    run(arguments);
  } catch (const nmc::Error& error) {
    fmt::print(stderr, "nmc-compare: {}\n", error.what());
    return static_cast<int>(error.code());
  } catch (const std::exception& error) {
    fmt::print(stderr, "nmc-compare: internal error: {}\n", error.what());
    return static_cast<int>(nmc::ExitCode::kInternal);
  }
  return 0;
}

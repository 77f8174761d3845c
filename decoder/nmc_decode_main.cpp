// SPDX-License-Identifier: Apache-2.0
// nmc-decode: a stream, or as much of it as is wanted, to a mesh file.
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <optional>
#include <vector>

#include "decoder/adaptive/adaptive_mesh.h"
#include "decoder/displacement/base_and_displacement.h"
#include "decoder/tool/quantity.h"
#include "decoder/tool/stream_source.h"
#include "decoder/tool/threads.h"
#include "decoder/tool/tool_main.h"
#include "decoder/write/mesh_writer.h"

namespace {

using namespace nmc;

struct Arguments {
  std::string input, output, format;
  std::optional<std::uint32_t> level;
  std::vector<std::uint32_t> regions;
  std::string max_error, rms_error, max_triangles, size, adaptive, base_and_displacement;
  bool allow_partial = false, prints_hash = false, no_output = false, quiet = false, force = false;
  int verbosity = 0;
  std::uint32_t repeat = 1;
  ThreadCount threads;
  std::string max_alloc, positions = "auto", normals = "none", progress = "auto";
  std::uint64_t max_triangles_limit = 0;
};

struct Choice {
  std::uint32_t row = 0;
  bool is_met = true;
};

/// The row of the layer table that the arguments ask for.
Choice choose_row(const Arguments& arguments, StreamReader& reader, const nmc_info& info) {
  Choice choice;
  choice.row = info.layer_count - 1;
  const auto select = [&](nmc_criterion criterion, double value) {
    if (reader.select_layer(criterion, value, choice.row, &choice.is_met) != NMC_OK) {
      throw ToolError(ToolExit::kInternal, "the layer table cannot be read");
    }
  };
  if (arguments.level) {
    if (*arguments.level > info.level_count) {
      throw ToolError(ToolExit::kUsage, "--level " + std::to_string(*arguments.level) +
                                            ": the stream has levels 0 to " +
                                            std::to_string(info.level_count));
    }
    select(NMC_BY_LEVEL, *arguments.level);
    choice.is_met = true;
  } else if (!arguments.max_error.empty()) {
    select(NMC_BY_MAX_ERROR, parse_length(arguments.max_error, info));
  } else if (!arguments.rms_error.empty()) {
    select(NMC_BY_RMS_ERROR, parse_length(arguments.rms_error, info));
  } else if (!arguments.max_triangles.empty()) {
    select(NMC_BY_FACES, parse_size(arguments.max_triangles));
  } else if (!arguments.size.empty()) {
    select(NMC_BY_BYTES, parse_size(arguments.size));
  }
  return choice;
}

/// Why nothing can be written although the stream is sound.
void refuse_unmet(const Arguments& arguments, StreamReader& reader, const nmc_info& info,
                  const std::string& name) {
  nmc_layer first{};
  if (reader.layer(0, first) != NMC_OK) return;
  if (!arguments.max_triangles.empty()) {
    throw ToolError(ToolExit::kTargetNotMet, name + ": even the coarsest layer has " +
                                                 std::to_string(first.face_count) +
                                                 " triangles; nothing was written");
  }
  if (!arguments.size.empty()) {
    throw ToolError(ToolExit::kTargetNotMet, name + ": the first layer takes " +
                                                 bytes_text(first.end_offset) + "; nothing was written");
  }
  (void)info;
}

void check_status(nmc_status status, const StreamReader& reader, const std::string& name) {
  if (status == NMC_OK) return;
  throw ToolError(exit_code_of(status), name + ": " + error_text(reader.error()));
}

/// Double precision where single would add more than a twentieth of the stated error.
bool needs_double(const Arguments& arguments, const nmc_info& info, const nmc_layer& layer) {
  if (arguments.positions != "auto") return arguments.positions == "double";
  double largest = 0;
  for (int k = 0; k < 3; ++k)
    largest = std::fmax(largest, std::fmax(std::fabs(info.box_min[k]), std::fabs(info.box_max[k])));
  double error = layer.has_error ? layer.rms_error : info.diagonal * 1e-5;
  if (!arguments.adaptive.empty()) error = std::fmax(error, parse_length(arguments.adaptive, info));
  return largest * 0x1p-24 > 0.05 * error;
}

OutputFormat output_format(const Arguments& arguments) {
  if (arguments.format == "ply-ascii") return OutputFormat::kPlyText;
  if (!arguments.format.empty()) {
    const std::optional<OutputFormat> format = output_format_from_name(arguments.format);
    if (!format)
      throw ToolError(ToolExit::kUsage,
                      "--format " + arguments.format + ": use ply, ply-ascii, obj, stl, off or glb");
    return *format;
  }
  if (arguments.output == "-") return OutputFormat::kPly;
  const std::string extension = std::filesystem::path(arguments.output).extension().string();
  const std::optional<OutputFormat> format = output_format_from_name(extension);
  if (!format) {
    throw ToolError(ToolExit::kUsage, arguments.output +
                                          ": the name does not end in .ply, .obj, .stl, .off or .glb; "
                                          "name the format with --format");
  }
  return *format;
}

void refuse_existing(const Arguments& arguments, const std::string& path) {
  std::error_code ignored;
  if (!arguments.force && std::filesystem::is_regular_file(path, ignored)) {
    throw ToolError(ToolExit::kUsage, path + ": exists already; use -f to overwrite it");
  }
}

void check_output(Arguments& arguments) {
  if (arguments.no_output) return;
  if (!arguments.base_and_displacement.empty()) {
    refuse_existing(arguments, arguments.base_and_displacement + ".obj");
    refuse_existing(arguments, arguments.base_and_displacement + ".exr");
    return;
  }
  if (arguments.output.empty()) {
    if (arguments.input == "-") throw ToolError(ToolExit::kUsage, "standard input needs -o");
    const std::string extension = arguments.format.empty() ? "ply" : arguments.format.substr(0, 3);
    arguments.output = std::filesystem::path(arguments.input).replace_extension(extension).string();
  }
  (void)output_format(arguments);
  if (arguments.output == "-") {
    if (isatty(STDOUT_FILENO))
      throw ToolError(ToolExit::kUsage, "a mesh is not written to a terminal; use -o FILE");
    return;
  }
  refuse_existing(arguments, arguments.output);
}

void check_written(const WriteStatus& written) {
  if (written.is_ok()) return;
  throw ToolError(written.outcome == WriteOutcome::kInputOutput   ? ToolExit::kInputOutput
                  : written.outcome == WriteOutcome::kUnsupported ? ToolExit::kUnsupported
                                                                  : ToolExit::kInternal,
                  written.message);
}

/// Keeps the three values of each vertex listed, in increasing order.
template <class Value>
void keep_vertices(const std::vector<std::uint32_t>& vertices, std::vector<Value>& values) {
  if (values.empty()) return;
  for (std::size_t i = 0; i < vertices.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) values[3 * i + k] = values[std::size_t{3} * vertices[i] + k];
  values.resize(3 * vertices.size());
}

/// What was written, for the line that tells it.
struct Written {
  std::uint64_t triangle_count = 0;
  double deviation = 0;  // from the level as decoded
};

Written write_displacement(const Arguments& arguments, StreamReader& reader, std::uint32_t level) {
  std::uint32_t vertex_count = 0, face_count = 0;
  check_status(reader.mesh_size(level, vertex_count, face_count), reader, arguments.input);
  const std::uint32_t base_face_count = face_count >> (2 * level);
  if (!fits_in_image(base_face_count, static_cast<int>(level))) {
    throw ToolError(ToolExit::kUnsupported, "the image would be wider than " +
                                                std::to_string(kLargestImageSide) +
                                                " texels; choose a coarser --level");
  }
  std::vector<std::uint32_t> indices(std::size_t{3} * face_count);
  std::vector<double> positions(std::size_t{3} * vertex_count);
  check_status(reader.read_indices(level, indices), reader, arguments.input);
  check_status(reader.read_positions(level, std::span<double>(positions)), reader, arguments.input);
  const BaseAndDisplacement data = make_base_and_displacement(indices, positions, static_cast<int>(level));
  check_written(
      write_base_and_displacement(arguments.base_and_displacement, data, positions, static_cast<int>(level)));
  return {base_face_count, 0};
}

Written write_output(const Arguments& arguments, StreamReader& reader, const nmc_info& info,
                     const nmc_layer& layer, std::uint32_t level) {
  std::uint32_t vertex_count = 0, face_count = 0;
  check_status(reader.mesh_size(level, vertex_count, face_count), reader, arguments.input);
  std::vector<std::uint32_t> indices(std::size_t{3} * face_count);
  std::vector<float> single, normals;
  std::vector<double> exact;
  check_status(reader.read_indices(level, indices), reader, arguments.input);
  MeshView view;
  const bool is_double = needs_double(arguments, info, layer);
  if (is_double || !arguments.adaptive.empty()) {
    exact.resize(std::size_t{3} * vertex_count);
    check_status(reader.read_positions(level, std::span<double>(exact)), reader, arguments.input);
  }
  if (!is_double) {
    single.resize(std::size_t{3} * vertex_count);
    check_status(reader.read_positions(level, std::span<float>(single)), reader, arguments.input);
  }
  if (arguments.normals == "vertex") {
    normals.resize(std::size_t{3} * vertex_count);
    check_status(reader.read_normals(level, normals), reader, arguments.input);
  }
  // A cut stream may end before its colours begin, and then there are none to write.
  std::vector<std::uint8_t> colors(info.has_colors ? std::size_t{3} * vertex_count : 0);
  if (!colors.empty() && reader.read_colors(level, colors) == NMC_ERR_STATE) colors.clear();
  Written result;
  if (!arguments.adaptive.empty()) {
    AdaptiveMesh adaptive =
        extract_adaptive(indices, exact, static_cast<int>(level), parse_length(arguments.adaptive, info));
    if (!is_double) exact.clear();
    keep_vertices(adaptive.source_vertices, exact);
    keep_vertices(adaptive.source_vertices, single);
    keep_vertices(adaptive.source_vertices, normals);
    keep_vertices(adaptive.source_vertices, colors);
    indices = std::move(adaptive.triangles);
    result.deviation = adaptive.largest_deviation;
  }
  view.positions_double = exact;
  view.positions_single = single;
  view.normals = normals;
  view.colors = colors;
  view.triangles = indices;
  check_written(write_mesh(arguments.output, view, output_format(arguments)));
  result.triangle_count = indices.size() / 3;
  return result;
}

void print_hashes(const Arguments& arguments, StreamReader& reader, const nmc_layer& layer,
                  std::uint32_t level) {
  std::uint64_t state = 0, positions = 0;
  check_status(reader.state_hash(state), reader, arguments.input);
  check_status(reader.position_hash(level, positions), reader, arguments.input);
  std::fprintf(arguments.output == "-" ? stderr : stdout, "layer %u level %u state %s positions %s\n",
               layer.index, level, hash_text(state).c_str(), hash_text(positions).c_str());
}

nmc_limits limits_of(const Arguments& arguments) {
  nmc_limits limits = nmc_default_limits();
  if (!arguments.max_alloc.empty())
    limits.max_memory = static_cast<std::uint64_t>(parse_size(arguments.max_alloc));
  // A triangle mesh has about half as many vertices as triangles, and three times as many at worst.
  if (arguments.max_triangles_limit > 0) limits.max_vertices = arguments.max_triangles_limit / 2 + 2;
  return limits;
}

void lend_threads(Arguments& arguments, StreamReader& reader) {
  if (arguments.threads.count != 1) check_status(reader.set_threads(run_on_threads, &arguments.threads), reader, "");
}

/// Decodes from memory again and again and tells the best time, mesh in hand.
ToolExit benchmark(Arguments& arguments) {
  const std::vector<std::uint8_t> bytes = read_file(arguments.input);
  StreamReader reader(limits_of(arguments));
  check_status(reader.status(), reader, arguments.input);
  lend_threads(arguments, reader);
  double best = 0;
  std::uint32_t face_count = 0;
  std::vector<float> positions;
  std::vector<std::uint32_t> indices;
  for (std::uint32_t i = 0; i < arguments.repeat; ++i) {
    const auto start = std::chrono::steady_clock::now();
    check_status(reader.reset(), reader, arguments.input);
    check_status(reader.feed(std::span<const std::uint8_t>(bytes)), reader, arguments.input);
    nmc_event event{};
    nmc_status status = NMC_OK;
    while ((status = reader.next(event)) == NMC_OK) {
    }
    if (status == NMC_NEED_MORE_INPUT) status = reader.finish();
    check_status(status, reader, arguments.input);
    nmc_layer layer{};
    std::uint32_t vertex_count = 0;
    check_status(reader.current_layer(layer), reader, arguments.input);
    check_status(reader.mesh_size(layer.level, vertex_count, face_count), reader, arguments.input);
    positions.resize(std::size_t{3} * vertex_count);
    indices.resize(std::size_t{3} * face_count);
    check_status(reader.read_indices(layer.level, indices), reader, arguments.input);
    check_status(reader.read_positions(layer.level, std::span<float>(positions)), reader, arguments.input);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    best = i == 0 || seconds < best ? seconds : best;
  }
  std::uint64_t peak = 0;
  check_status(nmc_decoder_memory(reader.get(), nullptr, &peak), reader, arguments.input);
  const double out = static_cast<double>(positions.size() + indices.size()) * 4;
  std::printf(
      "%s: %u triangles in %.2f ms (best of %u): %.2f million triangles/s, %.1f MB/s of output, %.1f bytes "
      "of "
      "memory per triangle with output\n",
      arguments.input.c_str(), face_count, best * 1000, arguments.repeat, face_count / best / 1e6,
      out / best / 1e6, (static_cast<double>(peak) + out) / face_count);
  return ToolExit::kOk;
}

ToolExit decode(Arguments& arguments) {
  check_output(arguments);
  if (arguments.repeat > 1 || (arguments.no_output && !arguments.prints_hash && arguments.repeat != 1)) {
    return benchmark(arguments);
  }
  StreamReader reader(limits_of(arguments));
  check_status(reader.status(), reader, arguments.input);
  lend_threads(arguments, reader);
  InputFile input(arguments.input);
  Choice choice;
  nmc_layer layer{};
  const bool shows_progress = !arguments.quiet && (arguments.progress == "always" ||
                                                   (arguments.progress == "auto" && isatty(STDERR_FILENO)));
  StreamVisitor visitor;
  visitor.on_header = [&](const nmc_info& info) {
    choice = choose_row(arguments, reader, info);
    if (!choice.is_met) refuse_unmet(arguments, reader, info, input.name());
    for (const std::uint32_t region : arguments.regions) {
      if (region < info.region_count) continue;
      throw ToolError(ToolExit::kUsage, "--regions " + std::to_string(region) + ": the stream has " +
                                            (info.region_count == 0 ? std::string("no regions")
                                                                    : "regions 0 to " +
                                                                          std::to_string(info.region_count - 1)));
    }
    return choice.row;
  };
  visitor.on_layer = [&](const nmc_layer& row) {
    layer = row;
    if (shows_progress || arguments.verbosity > 0) {
      std::fprintf(stderr, "layer %u: level %u, %llu triangles, %s read\n", row.index, row.level,
                   static_cast<unsigned long long>(row.face_count), bytes_text(row.end_offset).c_str());
    }
  };
  bool is_part = false;
  if (!arguments.regions.empty()) {
    visitor.skips = [&](const nmc_layer& row) {
      const auto region = static_cast<std::uint32_t>(row.region);
      const bool is_wanted = row.region < 0 || std::find(arguments.regions.begin(), arguments.regions.end(), region) !=
                                                   arguments.regions.end();
      is_part = is_part || !is_wanted;
      if (!is_wanted) layer = row;
      return !is_wanted && row.index <= choice.row;
    };
  }
  const StreamOutcome outcome = decode_stream(reader, input, visitor);
  if (is_part) layer.has_error = 0;  // that of the whole does not hold where it was left coarse
  const bool is_whole = outcome.status == NMC_OK;
  if (!is_whole) {
    const std::string reason = input.name() + ": " + error_text(reader.error());
    if (outcome.layers_complete == 0) {
      const ToolExit code =
          outcome.status == NMC_ERR_TRUNCATED ? ToolExit::kInvalidInput : exit_code_of(outcome.status);
      throw ToolError(code, reason + "; nothing could be decoded");
    }
    if (outcome.status != NMC_ERR_TRUNCATED && !arguments.allow_partial) {
      throw ToolError(exit_code_of(outcome.status),
                      reason + "; nothing was written (--allow-partial writes the " +
                          std::to_string(outcome.layers_complete) + " of " +
                          std::to_string(outcome.info.layer_count) + " layers before it)");
    }
  }
  const std::uint32_t level = arguments.level && is_whole ? *arguments.level : layer.level;
  if (arguments.prints_hash) print_hashes(arguments, reader, layer, level);
  Written written;
  if (!arguments.no_output) {
    written = arguments.base_and_displacement.empty()
                  ? write_output(arguments, reader, outcome.info, layer, level)
                  : write_displacement(arguments, reader, level);
  }
  if (!is_whole) {
    std::fprintf(stderr, "nmc-decode: %s: %s; decoded %u of %u layers from %s\n", input.name().c_str(),
                 error_text(reader.error()).c_str(), outcome.layers_complete, outcome.info.layer_count,
                 bytes_text(layer.end_offset).c_str());
    return arguments.allow_partial ? ToolExit::kOk : ToolExit::kCutOff;
  }
  if (!choice.is_met) {
    std::fprintf(
        stderr, "nmc-decode: %s: the stream does not reach that error; its finest layer was taken (%s)\n",
        input.name().c_str(),
        layer.has_error ? length_text(layer.max_error, outcome.info.units).c_str() : "error not stated");
    return ToolExit::kTargetNotMet;
  }
  if (!arguments.quiet && !arguments.no_output && arguments.output != "-") {
    const bool has_image = !arguments.base_and_displacement.empty();
    std::string line = has_image ? arguments.base_and_displacement + ".obj and .exr" : arguments.output;
    line += ": layer " + std::to_string(layer.index + 1) + " of " + std::to_string(outcome.info.layer_count) +
            ", " + bytes_text(layer.end_offset) + " -> " + std::to_string(written.triangle_count) +
            (has_image ? " base" : "") + " triangles";
    if (layer.has_error) line += ", max error " + length_text(layer.max_error, outcome.info.units);
    if (!arguments.adaptive.empty())
      line += ", and at most " + length_text(written.deviation, outcome.info.units) + " more for adaptivity";
    std::fprintf(stderr, "%s\n", line.c_str());
  }
  return ToolExit::kOk;
}

}  // namespace

int main(int argc, char** argv) {
  Arguments arguments;
  CLI::App app("Decodes a .nmc stream to a mesh file.", "nmc-decode");
  app.set_version_flag("-V,--version", version_line("nmc-decode"));
  app.add_option("INPUT", arguments.input, "a .nmc file, or - for standard input")->required();
  auto* output = app.add_option("-o,--output", arguments.output,
                                "mesh file, or - for standard output; default INPUT with .ply");
  app.add_option("--format", arguments.format,
                 "ply, ply-ascii, obj, stl, off or glb; default from the output's name");
  auto* how_much = app.add_option_group("How much (one of)");
  how_much->add_option("--level", arguments.level, "the mesh of level N (0: base mesh)");
  how_much->add_option("--max-error", arguments.max_error,
                       "the smallest prefix with this largest distance: 0.05mm, 0.003, 0.01%");
  how_much->add_option("--rms-error", arguments.rms_error, "the same for the root mean square distance");
  how_much->add_option("--max-triangles", arguments.max_triangles,
                       "the finest layer with at most so many triangles");
  how_much->add_option("--bytes", arguments.size, "what the first bytes give: 20kB, 1.5MiB");
  how_much->require_option(0, 1);
  app.add_option("--regions", arguments.regions,
                 "read and refine these regions of the surface alone, the rest stays coarse: 0,3,7 (nmc-info lists them)")
      ->delimiter(',');
  auto* adaptive = app.add_option(
      "--adaptive", arguments.adaptive,
      "large triangles where the mesh is flat: leave out what moves it by no more than this length "
      "(0.05mm, 0.003, 0.01% of the diagonal); no cracks");
  app.add_option(
         "--base-and-displacement", arguments.base_and_displacement,
         "instead of a mesh write PREFIX.obj, the base mesh with texture coordinates, and PREFIX.exr, vector "
         "displacements in object space; splitting each face into 4^level flat ones and displacing them "
         "gives "
         "the decoded mesh")
      ->type_name("PREFIX")
      ->excludes(adaptive)
      ->excludes(output);
  app.add_flag("--allow-partial", arguments.allow_partial,
               "a stream that is cut off or damaged is fine: write what there is");
  app.add_option("--positions", arguments.positions,
                 "float, double or auto: double where float would add to the error")
      ->check(CLI::IsMember({"auto", "float", "double"}));
  app.add_option("--normals", arguments.normals, "none, or vertex: normals weighted by area")
      ->check(CLI::IsMember({"none", "vertex"}));
  app.add_flag("--hash", arguments.prints_hash, "print the hashes of the decoded integers and positions");
  app.add_option("-j,--threads", arguments.threads.count, "threads for positions; 0: all. The mesh does not depend on it")
      ->capture_default_str();
  app.add_option("--max-alloc", arguments.max_alloc, "largest memory of the decoder, such as 500MB");
  app.add_option("--max-triangles-limit", arguments.max_triangles_limit,
                 "refuse larger meshes before allocating");
  app.add_option("--repeat", arguments.repeat, "decode N times from memory and print the best time")
      ->check(CLI::Range(1u, 1000000u));
  app.add_flag("--no-output", arguments.no_output, "write nothing");
  app.add_flag("-f,--force", arguments.force, "overwrite the output");
  app.add_flag("--quiet", arguments.quiet, "errors only");
  app.add_flag("-v", arguments.verbosity, "say more; may be repeated");
  app.add_option("--progress", arguments.progress, "auto, always or never")
      ->expected(0, 1)
      ->default_str("always")
      ->check(CLI::IsMember({"auto", "always", "never"}));
  return run_tool(app, argc, argv, [&] { return decode(arguments); });
}

// SPDX-License-Identifier: Apache-2.0
#include "encoder/tool/encode_file.h"

#include <fmt/core.h>
#include <oneapi/tbb/global_control.h>
#include <unistd.h>

#include <cinttypes>
#include <filesystem>
#include <memory>
#include <span>

#include "decoder/write/output_file.h"
#include "encoder/condition/condition_report.h"
#include "encoder/measure/compare_meshes.h"
#include "encoder/measure/stream_layers.h"
#include "encoder/pipeline/encode_mesh.h"
#include "encoder/pipeline/encode_report.h"
#include "encoder/read/mesh_reader.h"
#include "encoder/tool/progress_line.h"
#include "encoder/tool/progressive_glb.h"
#include "encoder/tool/vertex_map.h"

namespace nmc {

namespace {

void check_writable(const std::string& path, bool force) {
  if (path == "-") {
    if (isatty(STDOUT_FILENO))
      throw Error(ExitCode::kUsage, "a stream is not written to a terminal: say -o FILE");
    return;
  }
  if (!force && std::filesystem::exists(path)) {
    throw Error(ExitCode::kInputOutput, path + ": exists already; -f overwrites it");
  }
}

void write_file(const std::string& path, const void* data, std::size_t size) {
  OutputFile file(path);
  file.write(data, size);
  if (!file.commit()) throw Error(ExitCode::kInputOutput, file.error());
}

TriangleMesh read_input(const EncodeArguments& arguments, const std::string& input) {
  ReadOptions read;
  if (!arguments.input_format.empty()) {
    read.format = mesh_format_from_name(arguments.input_format);
    if (!read.format) throw Error(ExitCode::kUsage, "unknown format '" + arguments.input_format + "'");
  } else if (input == "-") {
    throw Error(ExitCode::kUsage, "standard input needs --format");
  }
  TriangleMesh mesh = read_mesh(input, read);
  if (arguments.strict && !mesh.dropped_properties.empty()) {
    throw Error(ExitCode::kUnsupported,
                input + ": '" + mesh.dropped_properties.front() + "' would be lost (--strict)");
  }
  return mesh;
}

std::string why_not_kept(const VertexAttribute& attribute) {
  const std::string& name = attribute.name;
  const bool is_normal = name == "nx" || name == "ny" || name == "nz" || name == "normal";
  return name + (is_normal ? ": the decoder derives normals from the surface" : ": attributes are not coded");
}

/// Measures what the decoder library makes of the bytes.
CompareResult verify(const TriangleMesh& input, const TriangleMesh& decoded) {
  CompareOptions options;
  options.normals = false;
  return compare_meshes(measurable_part(input), decoded, options);
}

/// The rooms behind do not know the file's name, but a message without it is of no use in a batch.
EncodeResult encode_named(const TriangleMesh& input, const EncodeOptions& options, const std::string& name) {
  try {
    return encode_mesh(input, options);
  } catch (const Error& error) {
    const std::string message = error.what();
    if (message.starts_with(name)) throw;
    throw Error(error.code(), name + ": " + message);
  }
}

}  // namespace

std::string output_of(const EncodeArguments& arguments, const std::string& input) {
  if (!arguments.output.empty()) return arguments.output;
  if (input == "-") throw Error(ExitCode::kUsage, "standard input has no name: say -o FILE");
  const std::filesystem::path beside = std::filesystem::path(input).replace_extension(".nmc");
  if (arguments.output_folder.empty()) return beside.string();
  return (std::filesystem::path(arguments.output_folder) / beside.filename()).string();
}

ExitCode encode_file(const EncodeArguments& arguments, const std::string& input_name,
                     const std::string& output) {
  const Stopwatch watch;
  EncodeOptions options = options_of(arguments);
  if (!arguments.dry_run) check_writable(output, arguments.force);
  if (!arguments.dry_run && !arguments.glb.empty()) check_writable(arguments.glb, arguments.force);

  const bool on_terminal = isatty(STDERR_FILENO) != 0;
  ProgressLine line(!arguments.quiet &&
                    (arguments.progress == "always" || (arguments.progress == "auto" && on_terminal)));
  options.progress = [&](std::string_view phase, double fraction) {
    if (arguments.timeout_seconds > 0 && watch.seconds() > arguments.timeout_seconds) {
      throw Error(ExitCode::kLimit, fmt::format("{}: stopped after {:.0f} s (--timeout); nothing was written",
                                                input_name, watch.seconds()));
    }
    line.show(phase, fraction);
  };

  line.show("reading", 0);
  const TriangleMesh input = read_input(arguments, input_name);
  // Without a box there is nothing to encode, and conditioning says why.
  const double box_diagonal = measurable_box(input).diagonal();
  const double diagonal = box_diagonal > 0 ? box_diagonal : 1;
  options.target = target_of(arguments, options.units, diagonal, input.vertex_count());
  if (!arguments.base_mesh.empty())
    options.base_mesh = std::make_shared<const TriangleMesh>(read_mesh(arguments.base_mesh, {}));

  const EncodeResult result = encode_named(input, options, input_name);

  ReportContext context;
  context.input_name = input_name;
  context.output_name = arguments.dry_run ? "(nothing written)" : output;
  std::error_code no_size;
  const auto input_bytes = std::filesystem::file_size(input_name, no_size);
  context.input_bytes = no_size ? 0 : input_bytes;
  context.dropped_properties = input.dropped_properties;
  for (const VertexAttribute& attribute : input.attributes)
    context.dropped_properties.push_back(why_not_kept(attribute));
  if (!input.colors.empty() && !result.colors)
    context.dropped_properties.emplace_back("vertex colours: left out (--colour off)");
  context.target = options.target;
  context.thread_count = static_cast<int>(
      oneapi::tbb::global_control::active_value(oneapi::tbb::global_control::max_allowed_parallelism));

  bool target_met = result.target_met;
  std::string verdict;
  if (arguments.verify || !arguments.vertex_map.empty()) {
    line.show("decoding", 0);
    const TriangleMesh decoded = read_stream(std::as_bytes(std::span(result.stream.bytes)), output);
    if (arguments.verify) {
      const CompareResult measured = verify(input, decoded);
      // The samples differ from those of the encoder's own measurement, hence the thousandth.
      constexpr double kTolerance = 1.001;
      const bool is_size = options.target.kind == TargetKind::kSize;
      const double value = is_size ? static_cast<double>(result.stream.bytes.size())
                           : options.target.kind == TargetKind::kRmsError ? measured.rms
                                                                          : measured.maximum;
      target_met = value <= options.target.value * (is_size ? 1 : kTolerance);
      verdict = fmt::format("verified: decoded again, max error {:.4g}, RMS {:.4g}: {}", measured.maximum,
                            measured.rms, target_met ? "target met" : "target NOT met");
    }
    if (!arguments.vertex_map.empty()) {
      const std::string csv = to_csv(map_vertices(input, decoded, result.stream.rows.back().level));
      write_file(arguments.vertex_map, csv.data(), csv.size());
    }
  }
  line.clear();
  context.seconds = watch.seconds();

  if (!arguments.dry_run) {
    write_file(output, result.stream.bytes.data(), result.stream.bytes.size());
    if (!arguments.glb.empty()) write_stream_as_glb(arguments.glb, result.stream.bytes);
  }
  if (!arguments.report.empty()) {
    const std::string json = report_json(result, context);
    write_file(arguments.report, json.data(), json.size());
  }
  if (!arguments.quiet) {
    if (result.condition.needed_repair() || arguments.verbosity > 0) {
      fmt::print(stderr, "{}", to_text(result.condition));
    }
    for (const std::string& dropped : context.dropped_properties)
      fmt::print(stderr, "not kept: {}\n", dropped);
    fmt::print(stderr, "{}\n", summary_line(result, context));
    const int region_count = result.stream.region_count;
    if (region_count < options.region_count) {
      fmt::print(stderr, "regions: {} of the {} asked for: {}\n",
                 region_count > 0 ? std::to_string(region_count) : "none", options.region_count,
                 region_count > 0 ? "there are no more base faces, or no more rows for them"
                                  : "a file of fewer than two levels has nothing to divide");
    }
    if (result.colors && !result.colors->is_met) {
      const double wanted = *options.color_psnr_db;
      if (result.colors->resolution_psnr_db < wanted + 0.5) {
        fmt::print(stderr,
                   "colours: {:.1f} of the {:g} dB asked for: they vary faster than the {} vertices that carry them\n",
                   result.colors->psnr_db, wanted, result.colors->vertex_count);
      } else {
        fmt::print(stderr, "colours: {:.1f} of the {:g} dB asked for: the size asked for leaves no more room\n",
                   result.colors->psnr_db, wanted);
      }
    }
    if (!verdict.empty()) fmt::print(stderr, "{}\n", verdict);
  }
  if (target_met) return ExitCode::kOk;
  fmt::print(stderr, "nmc-encode: {}: the target was not met; the nearest result was {}. {}\n", input_name,
             arguments.dry_run ? "not written (--dry-run)" : "written",
             arguments.effort < 9 ? "A higher --effort, more --base vertices or --levels may reach it"
                                  : "More --base vertices or --levels may reach it");
  return ExitCode::kTargetNotMet;
}

}  // namespace nmc

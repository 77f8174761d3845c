// SPDX-License-Identifier: Apache-2.0
// nmc-encode: a mesh file in, a stream out. A thin front of encoder/pipeline/encode_mesh.h.
#include <fmt/core.h>
#include <oneapi/tbb/global_control.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <thread>

#include "decoder/write/output_file.h"
#include "encoder/condition/condition_report.h"
#include "encoder/core/error.h"
#include "encoder/length_argument.h"
#include "encoder/pipeline/encode_mesh.h"
#include "encoder/pipeline/encode_report.h"
#include "encoder/read/mesh_reader.h"

namespace {

using nmc::Error;
using nmc::ExitCode;

constexpr const char* kVersion = "nmc-encode 0.1.0 (format 1)";

struct Arguments {
  std::string input, output, input_format;
  std::string max_error, rms_error, size;
  std::optional<double> bits_per_vertex, quality;
  int effort = 5;
  std::optional<int> base, levels;
  std::string domain = "general";
  int layers = 1;
  double crease = 0;
  std::string repair = "auto", units, up, report, progress = "auto";
  unsigned threads = 0;
  bool force = false, quiet = false, strict = false, keep_holes = false;
  int verbosity = 0;
};

/// Seconds since construction.
class Stopwatch {
 public:
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  }

 private:
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

/// One line on standard error that is rewritten in place.
class ProgressLine {
 public:
  explicit ProgressLine(bool enabled) : enabled_(enabled) {}
  ~ProgressLine() { clear(); }
  void show(std::string_view phase, double fraction) {
    if (!enabled_) return;
    fmt::print(stderr, "\r\x1b[K{} {:.0f} % ({:.0f} s)", phase, 100 * fraction, watch_.seconds());
    std::fflush(stderr);
    shown_ = true;
  }
  void clear() {
    if (shown_) fmt::print(stderr, "\r\x1b[K");
    shown_ = false;
  }

 private:
  bool enabled_, shown_ = false;
  Stopwatch watch_;
};

std::string default_output(const std::string& input) {
  if (input == "-") throw Error(ExitCode::kUsage, "standard input has no name: say -o FILE");
  return std::filesystem::path(input).replace_extension(".nmc").string();
}

/// Quality 0 ... 100 as a maximum error relative to the diagonal: 1 % at 0, 0.02 % at 75, 0.0055 % at 100.
double error_of_quality(double quality) { return 0.01 * std::pow(0.0055, quality / 100); }

nmc::Target target_of(const Arguments& arguments, nmc::Units units, double diagonal, std::size_t vertex_count) {
  nmc::Target target;
  if (!arguments.rms_error.empty()) {
    target.kind = nmc::TargetKind::kRmsError;
    target.value = length_in_input_units(nmc::parse_length(arguments.rms_error), units, diagonal);
  } else if (!arguments.size.empty()) {
    target.kind = nmc::TargetKind::kSize;
    target.value = nmc::parse_size(arguments.size);
  } else if (arguments.bits_per_vertex) {
    target.kind = nmc::TargetKind::kSize;
    target.value = *arguments.bits_per_vertex * static_cast<double>(vertex_count) / 8;
  } else if (arguments.quality) {
    target.kind = nmc::TargetKind::kMaximumError;
    target.value = error_of_quality(*arguments.quality) * diagonal;
  } else {
    target.kind = nmc::TargetKind::kMaximumError;
    target.value = length_in_input_units(
        nmc::parse_length(arguments.max_error.empty() ? "0.2%" : arguments.max_error), units, diagonal);
  }
  if (!(target.value > 0)) throw Error(ExitCode::kUsage, "the target must be greater than zero");
  return target;
}

void check_writable(const std::string& path, bool force) {
  if (path == "-") {
    if (isatty(STDOUT_FILENO)) throw Error(ExitCode::kUsage, "a stream is not written to a terminal: say -o FILE");
    return;
  }
  if (!force && std::filesystem::exists(path)) {
    throw Error(ExitCode::kInputOutput, path + ": exists already; -f overwrites it");
  }
}

void write_file(const std::string& path, const void* data, std::size_t size) {
  nmc::OutputFile file(path);
  file.write(data, size);
  if (!file.commit()) throw Error(ExitCode::kInputOutput, file.error());
}

int run(const Arguments& arguments) {
  const Stopwatch watch;
  nmc::EncodeOptions options;
  options.effort = arguments.effort;
  options.base_vertex_count = arguments.base;
  options.level_count = arguments.levels;
  options.domain = arguments.domain == "sphere" ? nmc::DomainChoice::kSphere
                   : arguments.domain == "auto" ? nmc::DomainChoice::kAuto
                                                : nmc::DomainChoice::kGeneral;
  options.quality_layer_count = arguments.layers;
  options.crease_angle_degrees = arguments.crease;
  if (!arguments.units.empty()) options.units = nmc::parse_units(arguments.units);
  if (!arguments.up.empty()) options.up_axis = arguments.up == "y" ? nmc::UpAxis::kY : nmc::UpAxis::kZ;
  options.condition.repair = arguments.repair == "none"     ? nmc::Repair::kNothing
                             : arguments.repair == "strict" ? nmc::Repair::kStrict
                                                            : nmc::Repair::kAuto;
  if (arguments.keep_holes) options.condition.small_hole_edges = 0;
  const std::string output = arguments.output.empty() ? default_output(arguments.input) : arguments.output;
  check_writable(output, arguments.force);

  const bool on_terminal = isatty(STDERR_FILENO) != 0;
  ProgressLine line(!arguments.quiet &&
                    (arguments.progress == "always" || (arguments.progress == "auto" && on_terminal)));
  options.progress = [&](std::string_view phase, double fraction) { line.show(phase, fraction); };

  line.show("reading", 0);
  nmc::ReadOptions read;
  if (!arguments.input_format.empty()) {
    read.format = nmc::mesh_format_from_name(arguments.input_format);
    if (!read.format) throw Error(ExitCode::kUsage, "unknown format '" + arguments.input_format + "'");
  } else if (arguments.input == "-") {
    throw Error(ExitCode::kUsage, "standard input needs --format");
  }
  const nmc::TriangleMesh input = nmc::read_mesh(arguments.input, read);
  if (arguments.strict && !input.dropped_properties.empty()) {
    throw Error(ExitCode::kUnsupported,
                arguments.input + ": '" + input.dropped_properties.front() + "' would be lost (--strict)");
  }
  // Without a box there is nothing to encode, and conditioning says why.
  const double box_diagonal = nmc::measurable_box(input).diagonal();
  const double diagonal = box_diagonal > 0 ? box_diagonal : 1;
  options.target = target_of(arguments, options.units, diagonal, input.vertex_count());

  const nmc::EncodeResult result = nmc::encode_mesh(input, options);
  line.clear();

  nmc::ReportContext context;
  context.input_name = arguments.input;
  context.output_name = output;
  std::error_code no_size;
  const auto input_bytes = std::filesystem::file_size(arguments.input, no_size);
  context.input_bytes = no_size ? 0 : input_bytes;
  context.dropped_properties = input.dropped_properties;
  for (const nmc::VertexAttribute& attribute : input.attributes)
    context.dropped_properties.push_back(attribute.name + ": attributes are not coded");
  if (!input.colors.empty()) context.dropped_properties.emplace_back("vertex colours: not coded");
  context.target = options.target;
  context.thread_count = static_cast<int>(
      oneapi::tbb::global_control::active_value(oneapi::tbb::global_control::max_allowed_parallelism));
  context.seconds = watch.seconds();

  write_file(output, result.stream.bytes.data(), result.stream.bytes.size());
  if (!arguments.report.empty()) {
    const std::string json = report_json(result, context);
    write_file(arguments.report, json.data(), json.size());
  }
  if (!arguments.quiet) {
    if (result.condition.needed_repair() || arguments.verbosity > 0) {
      fmt::print(stderr, "{}", to_text(result.condition));
    }
    for (const std::string& dropped : context.dropped_properties) fmt::print(stderr, "not kept: {}\n", dropped);
    fmt::print(stderr, "{}\n", summary_line(result, context));
  }
  if (!result.target_met) {
    fmt::print(stderr, "nmc-encode: {}: the target was not met; the nearest result was written. {}\n",
               arguments.input,
               arguments.effort < 9 ? "A higher --effort, more --base vertices or --levels may reach it"
                                    : "More --base vertices or --levels may reach it");
    return static_cast<int>(ExitCode::kTargetNotMet);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "Compress a dense triangle surface. The result is a new, semi-regular mesh of the same shape; vertex order\n"
      "and connectivity of INPUT are not kept.");
  Arguments arguments;
  app.add_option("INPUT", arguments.input, "mesh file: .ply .obj .stl .off .gltf .glb, or - (needs --format)")
      ->required();
  app.add_option("-o,--output", arguments.output, "stream to write, or - (default: INPUT with .nmc)");
  app.add_option("--format", arguments.input_format, "format of INPUT: ply, obj, stl, off, gltf, glb");

  auto* target = app.add_option_group("How good", "choose one; default --max-error 0.2%");
  target->add_option("-E,--max-error", arguments.max_error,
                     "largest distance to INPUT, both ways, measured: 0.05mm, 0.003 (input units) or 0.2% (of the\n"
                     "diagonal). Typical: 0.5% preview, 0.2% web, 0.05% archive");
  target->add_option("--rms-error", arguments.rms_error,
                     "the same, root mean square. Typical: 0.05% preview, 0.02% web, 0.005% archive");
  target->add_option("--size", arguments.size, "largest file: 500kB, 2MB, 1.5MiB");
  target->add_option("--bpv", arguments.bits_per_vertex, "bits per input vertex. Typical: 0.3 ... 4");
  target->add_option("-q,--quality", arguments.quality, "0 ... 100, mapped to --max-error: 1 % at 0, 0.0055 % at 100")
      ->check(CLI::Range(0.0, 100.0));
  target->require_option(0, 1);

  app.add_option("-e,--effort", arguments.effort, "1 ... 9: how hard to search; same format, same decoder")
      ->check(CLI::Range(1, 9))
      ->capture_default_str();
  app.add_option("--base", arguments.base, "vertices of the base mesh (default: chosen by cost)")
      ->check(CLI::Range(3, 1000000));
  app.add_option("--domain", arguments.domain,
                 "general: a base mesh of any topology; sphere: for closed shapes without handles; auto: the better one")
      ->check(CLI::IsMember({"general", "sphere", "auto"}))
      ->capture_default_str();
  app.add_option("--levels", arguments.levels, "subdivision levels (default: chosen by cost)")
      ->check(CLI::Range(1, 10));
  app.add_option("--layers", arguments.layers,
                 "quality layers, 1 ... 6: each refines all levels, so prefixes are better and the whole is larger")
      ->check(CLI::Range(1, 6))
      ->capture_default_str();
  app.add_option("--crease", arguments.crease, "keep edges sharper than this angle in degrees; 0: none")
      ->check(CLI::Range(0.0, 180.0));
  app.add_option("--repair", arguments.repair, "auto: repair and report; none: refuse; strict: refuse any defect")
      ->check(CLI::IsMember({"auto", "none", "strict"}))
      ->capture_default_str();
  app.add_flag("--keep-holes", arguments.keep_holes, "do not fill small holes");
  app.add_flag("--strict", arguments.strict, "a property of INPUT that is not kept is an error");
  app.add_option("--units", arguments.units, "units of INPUT, recorded: mm, cm, m, in, ft, km");
  app.add_option("--up", arguments.up, "up axis of INPUT, recorded")->check(CLI::IsMember({"y", "z"}));
  app.add_option("--report", arguments.report, "write statistics as JSON to this file, or -");
  app.add_option("-j,--threads", arguments.threads, "threads; 0: all. The output does not depend on it");
  app.add_option("--progress", arguments.progress, "auto, always, never")
      ->check(CLI::IsMember({"auto", "always", "never"}));
  app.add_flag("-f,--force", arguments.force, "overwrite the output");
  app.add_flag("--quiet", arguments.quiet, "print errors only");
  app.add_flag("-v,--verbose", arguments.verbosity, "more to read");
  app.set_version_flag("-V,--version", kVersion);

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : static_cast<int>(ExitCode::kUsage);
  }
  nmc::OutputFile::remove_part_file_on_signals();
  try {
    std::optional<oneapi::tbb::global_control> limit;
    if (arguments.threads > 0) {
      limit.emplace(oneapi::tbb::global_control::max_allowed_parallelism, arguments.threads);
    }
    return run(arguments);
  } catch (const Error& error) {
    fmt::print(stderr, "nmc-encode: {}\n", error.what());
    return static_cast<int>(error.code());
  } catch (const std::bad_alloc&) {
    fmt::print(stderr, "nmc-encode: {}: out of memory\n", arguments.input);
    return static_cast<int>(ExitCode::kLimit);
  } catch (const std::exception& error) {
    fmt::print(stderr, "nmc-encode: {}: internal error: {}\n", arguments.input, error.what());
    return static_cast<int>(ExitCode::kInternal);
  }
}

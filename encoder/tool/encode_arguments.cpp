// SPDX-License-Identifier: Apache-2.0
#include "encoder/tool/encode_arguments.h"

#include <fast_float/fast_float.h>

#include <cmath>

#include "encoder/core/error.h"
#include "encoder/tool/length_argument.h"

namespace nmc {

namespace {

/// Quality 0 ... 100 as a maximum error relative to the diagonal: 1 % at 0, 0.02 % at 75, 0.0055 % at 100.
double error_of_quality(double quality) { return 0.01 * std::pow(0.0055, quality / 100); }

}  // namespace

void declare_options(CLI::App& app, EncodeArguments& arguments) {
  app.add_option("INPUT", arguments.inputs,
                 "mesh files: .ply .obj .stl .off .gltf .glb; or - for standard input (needs --format)");
  app.add_option("-o,--output", arguments.output, "stream to write, or - (default: INPUT with .nmc)");
  app.add_option("--format", arguments.input_format, "format of INPUT: ply, obj, stl, off, gltf, glb");

  auto* many = app.add_option_group("Many files", "a file that fails is reported and the others go on");
  many->add_option("--batch", arguments.batch,
                   "a folder: every mesh file in it; or a text file: one mesh file per line");
  many->add_option("--output-dir", arguments.output_folder,
                   "folder of the streams (default: beside each INPUT)");

  auto* target = app.add_option_group("How good", "choose one; default --max-error 0.2%");
  target->add_option(
      "-E,--max-error", arguments.max_error,
      "largest distance to INPUT, both ways, measured: 0.05mm, 0.003 (input units) or 0.2% (of the\n"
      "diagonal). Typical: 0.5% preview, 0.2% web, 0.05% archive");
  target->add_option("--rms-error", arguments.rms_error,
                     "the same, root mean square. Typical: 0.05% preview, 0.02% web, 0.005% archive");
  target->add_option("--size", arguments.size, "largest file: 500kB, 2MB, 1.5MiB");
  target->add_option("--bpv", arguments.bits_per_vertex, "bits per input vertex. Typical: 0.3 ... 4");
  target
      ->add_option("-q,--quality", arguments.quality,
                   "0 ... 100, mapped to --max-error: 1 % at 0, 0.0055 % at 100")
      ->check(CLI::Range(0.0, 100.0));
  target->require_option(0, 1);

  app.add_option("-e,--effort", arguments.effort, "1 ... 9: how hard to search; same format, same decoder")
      ->check(CLI::Range(1, 9))
      ->capture_default_str();
  app.add_option("--base", arguments.base, "vertices of the base mesh (default: chosen by cost)")
      ->check(CLI::Range(3, 1000000));
  app.add_option("--domain", arguments.domain,
                 "general: a base mesh of any topology; sphere: for closed shapes without handles;\n"
                 "input: for remeshes with subdivision connectivity, on their own base mesh; auto: the best of them")
      ->check(CLI::IsMember({"general", "sphere", "input", "auto"}))
      ->capture_default_str();
  app.add_option("--base-mesh", arguments.base_mesh,
                 "with --domain input: the base mesh of INPUT as a file; INPUT is it with all triangles split in\n"
                 "four, --levels times (default: as often as its triangles say)");
  app.add_option("--levels", arguments.levels, "subdivision levels (default: chosen by cost)")
      ->check(CLI::Range(1, 10));
  app.add_option(
         "--layers", arguments.layers,
         "quality layers, 1 ... 6: each refines all levels, so prefixes are better and the whole is larger")
      ->check(CLI::Range(1, 6))
      ->capture_default_str();
  app.add_option("--regions", arguments.regions,
                 "parts of the surface that can be fetched and refined alone, 1 ... 64; 0: none. Each takes some\n"
                 "20 bytes per quality layer")
      ->check(CLI::Range(0, 64))
      ->capture_default_str();
  app.add_option("--crease", arguments.crease, "keep edges sharper than this angle in degrees; 0: none")
      ->check(CLI::Range(0.0, 180.0));
  app.add_option("--repair", arguments.repair,
                 "auto: repair and report; none: refuse; strict: refuse any defect")
      ->check(CLI::IsMember({"auto", "none", "strict"}))
      ->capture_default_str();
  app.add_option("--colour,--color", arguments.colour,
                 "vertex colours: auto (38 dB), off, or the wanted ratio of signal to noise in dB, 20 ... 60.\n"
                 "Typical: 34 preview, 38 web, 44 archive")
      ->capture_default_str();
  app.add_flag("--keep-holes", arguments.keep_holes, "do not fill small holes");
  app.add_flag("--strict", arguments.strict, "a property of INPUT that is not kept is an error");
  app.add_option("--units", arguments.units, "units of INPUT, recorded: mm, cm, m, in, ft, km");
  app.add_option("--up", arguments.up, "up axis of INPUT, recorded")->check(CLI::IsMember({"y", "z"}));

  app.add_flag(
      "--verify", arguments.verify,
      "decode the finished bytes with the decoder library and measure again; exit code 7 if over the target");
  app.add_flag("--dry-run", arguments.dry_run, "do everything, print the result, write no stream");
  app.add_option("--report", arguments.report, "write statistics as JSON to this file, or -");
  app.add_option(
      "--emit-map", arguments.vertex_map,
      "write for each vertex of INPUT where it went, as CSV: base face, u, v, height over the result");
  app.add_option("--glb", arguments.glb,
                 "write a GLB too: a coarse plain mesh that carries the stream (NMC_progressive_mesh)");
  app.add_option("-j,--threads", arguments.threads, "threads; 0: all. The output does not depend on it");
  app.add_option("--memory-limit", arguments.memory_limit,
                 "give up with exit code 6 instead of taking more memory: 4GB, 500MiB");
  app.add_option("--timeout", arguments.timeout_seconds,
                 "give up on a file after this many seconds, exit code 6")
      ->check(CLI::NonNegativeNumber);
  app.add_option("--progress", arguments.progress, "auto, always, never")
      ->check(CLI::IsMember({"auto", "always", "never"}));
  app.add_flag("-f,--force", arguments.force, "overwrite the output");
  app.add_flag("--quiet", arguments.quiet, "print errors only");
  app.add_flag("-v,--verbose", arguments.verbosity, "more to read");
}

EncodeOptions options_of(const EncodeArguments& arguments) {
  EncodeOptions options;
  options.effort = arguments.effort;
  options.base_vertex_count = arguments.base;
  options.level_count = arguments.levels;
  options.domain = arguments.domain == "sphere"  ? DomainChoice::kSphere
                   : arguments.domain == "input" ? DomainChoice::kInput
                   : arguments.domain == "auto"  ? DomainChoice::kAuto
                                                 : DomainChoice::kGeneral;
  if (!arguments.base_mesh.empty() && options.domain != DomainChoice::kInput)
    throw Error(ExitCode::kUsage, "--base-mesh goes with --domain input");
  if (!arguments.base_mesh.empty() && arguments.base)
    throw Error(ExitCode::kUsage, "--base-mesh and --base exclude each other");
  options.quality_layer_count = arguments.layers;
  options.region_count = arguments.regions;
  options.crease_angle_degrees = arguments.crease;
  if (!arguments.units.empty()) options.units = parse_units(arguments.units);
  if (!arguments.up.empty()) options.up_axis = arguments.up == "y" ? UpAxis::kY : UpAxis::kZ;
  options.condition.repair = arguments.repair == "none"     ? Repair::kNothing
                             : arguments.repair == "strict" ? Repair::kStrict
                                                            : Repair::kAuto;
  if (arguments.colour == "off") {
    options.color_psnr_db.reset();
  } else if (arguments.colour != "auto") {
    const char* const end = arguments.colour.data() + arguments.colour.size();
    double decibels = 0;
    const auto [rest, error] = fast_float::from_chars(arguments.colour.data(), end, decibels);
    if (error != std::errc() || rest != end || !(decibels >= 20 && decibels <= 60))
      throw Error(ExitCode::kUsage, "--colour " + arguments.colour + ": use auto, off or 20 ... 60 (dB)");
    options.color_psnr_db = decibels;
  }
  if (arguments.keep_holes) options.condition.small_hole_edges = 0;
  return options;
}

Target target_of(const EncodeArguments& arguments, Units units, double diagonal, std::size_t vertex_count) {
  Target target;
  if (!arguments.rms_error.empty()) {
    target.kind = TargetKind::kRmsError;
    target.value = length_in_input_units(parse_length(arguments.rms_error), units, diagonal);
  } else if (!arguments.size.empty()) {
    target.kind = TargetKind::kSize;
    target.value = parse_size(arguments.size);
  } else if (arguments.bits_per_vertex) {
    target.kind = TargetKind::kSize;
    target.value = *arguments.bits_per_vertex * static_cast<double>(vertex_count) / 8;
  } else if (arguments.quality) {
    target.kind = TargetKind::kMaximumError;
    target.value = error_of_quality(*arguments.quality) * diagonal;
  } else {
    target.kind = TargetKind::kMaximumError;
    target.value = length_in_input_units(
        parse_length(arguments.max_error.empty() ? "0.2%" : arguments.max_error), units, diagonal);
  }
  if (!(target.value > 0)) throw Error(ExitCode::kUsage, "the target must be greater than zero");
  return target;
}

}  // namespace nmc

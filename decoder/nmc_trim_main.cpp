// SPDX-License-Identifier: Apache-2.0
// nmc-trim: a shorter stream from a longer one, without encoding anew. Streams are cut behind a row of their
// layer table, and the header is written for what is left.
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <optional>

#include "decoder/tool/cut_stream.h"
#include "decoder/tool/quantity.h"
#include "decoder/tool/stream_source.h"
#include "decoder/tool/tool_main.h"

namespace {

using namespace nmc;

struct Arguments {
  std::string input, output, size, max_error, rms_error, max_triangles;
  std::optional<std::uint32_t> level;
  std::vector<std::uint32_t> regions;
  bool force = false, quiet = false;
};

/// The stream up to the end of row `last_row`, of all regions or those listed.
Array<std::uint8_t> cut_to_row(const std::vector<std::uint8_t>& bytes, const std::vector<std::uint32_t>& regions,
                               std::uint32_t last_row) {
  Array<std::uint8_t> result;
  const Status status = cut_to_regions(
      bytes, last_row,
      [&](std::uint32_t region) {
        return regions.empty() || std::find(regions.begin(), regions.end(), region) != regions.end();
      },
      result);
  if (status.code() == StatusCode::kNoMemory) throw std::bad_alloc();
  if (!status.ok()) throw ToolError(ToolExit::kInternal, "the header cannot be read a second time");
  return result;
}

ToolExit trim(const Arguments& arguments) {
  if (arguments.output == "-" && isatty(STDOUT_FILENO)) {
    throw ToolError(ToolExit::kUsage, "a stream is not written to a terminal; use -o FILE");
  }
  std::error_code ignored;
  if (!arguments.force && arguments.output != "-" &&
      std::filesystem::is_regular_file(arguments.output, ignored)) {
    throw ToolError(ToolExit::kUsage, arguments.output + ": exists already; use -f to overwrite it");
  }
  const std::vector<std::uint8_t> bytes = read_file(arguments.input);
  StreamReader reader;
  const auto check = [&](nmc_status status) {
    if (status == NMC_OK) return;
    throw ToolError(exit_code_of(status), arguments.input + ": " + error_text(reader.error()));
  };
  check(reader.status());
  check(reader.feed(std::span<const std::uint8_t>(bytes)));
  nmc_event event{};
  nmc_info info{};
  nmc_status status = reader.next(event);
  if (status == NMC_NEED_MORE_INPUT) {
    (void)!reader.finish();
    throw ToolError(ToolExit::kInvalidInput, arguments.input + ": " + error_text(reader.error()));
  }
  check(status);
  check(reader.info(info));

  for (const std::uint32_t region : arguments.regions) {
    if (region >= info.region_count) {
      throw ToolError(ToolExit::kUsage, "--regions " + std::to_string(region) + ": the stream has " +
                                            std::to_string(info.region_count) + " regions, counted from 0");
    }
  }
  const auto cut_to = [&](std::uint32_t last_row) { return cut_to_row(bytes, arguments.regions, last_row); };
  std::uint32_t row = info.layer_count - 1;
  bool is_met = true;
  if (!arguments.max_error.empty()) {
    check(reader.select_layer(NMC_BY_MAX_ERROR, parse_length(arguments.max_error, info), row, &is_met));
  } else if (!arguments.rms_error.empty()) {
    check(reader.select_layer(NMC_BY_RMS_ERROR, parse_length(arguments.rms_error, info), row, &is_met));
  } else if (!arguments.max_triangles.empty()) {
    check(reader.select_layer(NMC_BY_FACES, parse_size(arguments.max_triangles), row, &is_met));
  } else if (arguments.level) {
    check(reader.select_layer(NMC_BY_LEVEL, *arguments.level, row, &is_met));
  }
  // What is kept must be sound: decoding it is the only proof.
  for (std::uint32_t complete = 0; complete <= row;) {
    status = reader.next(event);
    if (status == NMC_NEED_MORE_INPUT) status = reader.finish();
    if (status != NMC_OK && !arguments.size.empty() && complete > 0) {
      row = complete - 1;  // a size may ask for less than is damaged
      break;
    }
    check(status);
    complete += event == NMC_EVENT_LAYER;
  }
  Array<std::uint8_t> result = cut_to(row);
  if (!arguments.size.empty()) {
    const double limit = parse_size(arguments.size);
    while (static_cast<double>(result.size()) > limit && row > 0) result = cut_to(--row);
    is_met = static_cast<double>(result.size()) <= limit;
  }
  if (!is_met) {
    const bool by_error = !arguments.max_error.empty() || !arguments.rms_error.empty();
    throw ToolError(ToolExit::kTargetNotMet,
                    arguments.input +
                        (by_error ? ": the whole stream does not reach that error"
                                  : ": the first layer takes " + bytes_text(cut_to(0).size()) +
                                        " and is too large") +
                        "; nothing was written");
  }
  if (!arguments.regions.empty()) {
    // Fewer bytes may describe fewer vertices (section 8.2 of the format).
    const std::vector<std::uint8_t> part(result.begin(), result.end());
    StreamReader again;
    check(again.feed(std::span<const std::uint8_t>(part)));
    while ((status = again.next(event)) == NMC_OK) {
    }
    if (status == NMC_NEED_MORE_INPUT) status = again.finish();
    if (status != NMC_OK) {
      throw ToolError(exit_code_of(status),
                      arguments.input + ": what would be left is no valid stream: " + error_text(again.error()));
    }
  }
  OutputFile output(arguments.output);
  output.write(result.data(), result.size());
  if (!output.commit()) throw ToolError(ToolExit::kInputOutput, output.error());
  if (!arguments.quiet && arguments.output != "-") {
    nmc_layer layer{};
    check(reader.layer(row, layer));
    std::fprintf(stderr, "%s: %s of %s, %u of %u layers, %llu triangles%s\n", arguments.output.c_str(),
                 bytes_text(result.size()).c_str(), bytes_text(bytes.size()).c_str(), row + 1,
                 info.layer_count, static_cast<unsigned long long>(layer.face_count),
                 layer.has_error && arguments.regions.empty() ? (", max error " + length_text(layer.max_error, info.units)).c_str() : "");
  }
  return ToolExit::kOk;
}

}  // namespace

int main(int argc, char** argv) {
  Arguments arguments;
  CLI::App app("Cuts a .nmc stream behind one of its layers; nothing is encoded anew.", "nmc-trim");
  app.set_version_flag("-V,--version", version_line("nmc-trim"));
  app.add_option("INPUT", arguments.input, "a .nmc file, or - for standard input")->required();
  app.add_option("-o,--output", arguments.output, "the shorter stream, or - for standard output")->required();
  auto* how_much = app.add_option_group("How much (one of)");
  how_much->add_option("--size", arguments.size, "largest file: 500kB, 1.5MiB");
  how_much->add_option("--max-error", arguments.max_error,
                       "the shortest stream with this largest distance: 0.05mm, 0.01%");
  how_much->add_option("--rms-error", arguments.rms_error, "the same for the root mean square distance");
  how_much->add_option("--max-triangles", arguments.max_triangles,
                       "the longest stream with at most so many triangles");
  how_much->add_option("--level", arguments.level, "the longest stream shown at this level or a coarser one");
  app.add_option("--regions", arguments.regions, "keep these regions of the surface alone: 0,3,7; the rest stays coarse")
      ->delimiter(',');
  how_much->require_option(0, 1);
  app.add_flag("-f,--force", arguments.force, "overwrite the output");
  app.add_flag("--quiet", arguments.quiet, "errors only");
  return run_tool(app, argc, argv, [&] {
    if (how_much->count_all() == 0 && arguments.regions.empty())
      throw ToolError(ToolExit::kUsage, "one of --size, --max-error, --rms-error, --max-triangles, --level, --regions is needed");
    return trim(arguments);
  });
}

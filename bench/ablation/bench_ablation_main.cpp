// SPDX-License-Identifier: Apache-2.0
// nmc-bench-ablation MESH... --rms 2e-4 1e-4: what each part of the encoder is worth.
//
// Every row is a whole stream by the real coder, header and layer table included, at the coarsest step whose
// decoded mesh meets the error, measured both ways over the diagonal. All rows but the last share one base
// and one number of levels (--base, --levels).
//
//   open loop            the interpolating mesh, every coefficient rounded by itself
//
//   closed loop          the same, each level pierced from the decoded coarser one; no least squares
//
//   fit, rounded         the global fit, every coefficient rounded by itself
//
//   fit, quantized       the global fit with its quantizer
//
//   + smoothing level    one more level that the decoder only predicts, or the last one only predicted
//
//   + chosen base size   the whole encoder
//
// Decibels are against the open loop at the open loop's bytes: a row's bytes at two errors give the power by
// which its error falls with its bytes. So at least two errors are needed for them.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "bench/ablation/rows.h"
#include "encoder/core/error.h"

namespace {

using nmc_bench::Row;

struct Arguments {
  std::vector<std::string> meshes;
  std::vector<double> errors{2e-4, 1e-4};  // over the diagonal
  nmc_bench::AblationOptions ablation;
  int effort = 5;  // of the last row
  std::string csv, results;
};

/// Bytes by the real coder, or where the row stands for the encoder before mixing by one context each.
struct Line {
  std::string name;
  std::vector<double> bytes;  // by error; 0: not met
};

double gain_in_decibels(const Line& open_loop, const Line& line, const std::vector<double>& errors,
                        std::size_t i) {
  const std::size_t first = 0, last = errors.size() - 1;
  const bool has_all = open_loop.bytes[i] > 0 && line.bytes[first] > 0 && line.bytes[last] > 0;
  if (!has_all || first == last) return std::nan("");
  const double power =
      std::log(line.bytes[last] / line.bytes[first]) / std::log(errors[first] / errors[last]);
  return 20 * std::log10(open_loop.bytes[i] / line.bytes[i]) / power;
}

void print_table(const std::vector<double>& errors, const std::vector<std::vector<Row>>& by_error) {
  std::vector<Line> lines;
  for (std::size_t r = 0; r < by_error.front().size(); ++r) {
    Line real{by_error.front()[r].name, {}}, plain = real;
    for (const std::vector<Row>& rows : by_error) {
      real.bytes.push_back(static_cast<double>(rows[r].byte_count));
      plain.bytes.push_back(rows[r].is_met() && rows[r].bits ? rows[r].one_context_bytes() : 0);
    }
    const bool is_before_mixing = r < 4;
    if (is_before_mixing) lines.push_back(plain);
    if (r == 3) real.name = "+ mixing";
    if (r >= 3) lines.push_back(real);
  }
  fmt::print("| |");
  for (const double error : errors) fmt::print(" {:.0e} | dB |", error);
  fmt::print("\n|---|");
  for (std::size_t i = 0; i < errors.size(); ++i) fmt::print("--:|--:|");
  fmt::print("\n");
  for (const Line& line : lines) {
    fmt::print("| {} |", line.name);
    for (std::size_t i = 0; i < errors.size(); ++i) {
      if (line.bytes[i] > 0)
        fmt::print(" {:.0f} | {:+.1f} |", line.bytes[i], gain_in_decibels(lines.front(), line, errors, i));
      else
        fmt::print(" not met | |");
    }
    fmt::print("\n");
  }
  fmt::print("\n");
  std::fflush(stdout);
}

void write_csv(std::FILE* file, const std::string& mesh, double error, const Row& row, double diagonal) {
  fmt::print(file, "{},{:g},{},{},{},{:.4e},{},{},{},{:.4e},{:.4e}\n", mesh, error, row.name,
             row.base_vertex_count, row.level_count, row.step / diagonal, row.byte_count,
             row.bits && row.is_met() ? fmt::format("{:.0f}", row.one_context_bytes()) : "",
             row.bits && row.is_met() ? fmt::format("{:.0f}", row.untrained_bytes()) : "",
             row.error.rms / diagonal, row.error.maximum / diagonal);
  std::fflush(file);
}

/// Rows of bench/rd for `mesh`: the whole encoder as it was measured there.
std::optional<Row> known_result(const std::string& results, const std::string& mesh, double error,
                                double diagonal) {
  std::ifstream file(results);
  if (!file) throw nmc::Error(nmc::ExitCode::kInputOutput, "cannot read " + results);
  std::string line;
  while (std::getline(file, line)) {
    std::vector<std::string> cells;
    std::stringstream stream(line);
    for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
    constexpr std::size_t kMesh = 0, kSettings = 1, kTarget = 2, kOutcome = 3, kBytes = 4, kRms = 5,
                          kMaximum = 6;
    if (cells.size() <= kMaximum || cells[kMesh] != mesh || !cells[kSettings].empty() ||
        cells[kOutcome] != "ok")
      continue;
    if (std::abs(std::stod(cells[kTarget]) / error - 1) > 1e-6) continue;
    Row row;
    row.name = nmc_bench::kWholeEncoder;
    row.byte_count = std::stoul(cells[kBytes]);
    row.error = {std::stod(cells[kRms]) * diagonal, std::stod(cells[kMaximum]) * diagonal};
    return row;
  }
  return std::nullopt;
}

/// Opens for appending; a new file gets its head.
std::FILE* open_csv(const std::string& path) {
  const bool is_new = !std::filesystem::exists(path);
  std::FILE* file = std::fopen(path.c_str(), "a");
  if (!file) throw nmc::Error(nmc::ExitCode::kInputOutput, "cannot write " + path);
  if (is_new)
    fmt::print(
        file,
        "mesh,asked_rms,row,base_vertices,levels,step,bytes,bytes_one_context,bytes_untrained,rms,max\n");
  return file;
}

void run(const Arguments& arguments) {
  std::FILE* csv = arguments.csv.empty() ? nullptr : open_csv(arguments.csv);
  for (const std::string& path : arguments.meshes) {
    const nmc_bench::Scan scan = nmc_bench::read_scan(path);
    const double diagonal = scan.reference.diagonal;
    nmc_bench::AblationOptions options = arguments.ablation;
    for (const double error : arguments.errors) options.errors.push_back(error * diagonal);
    options.done = [&](std::size_t i, const Row& row) {
      fmt::print("{} {:.0e} {:<20} base {:>5} levels {} bytes {:>7} rms {:.4e} max {:.2e}\n", scan.name,
                 arguments.errors[i], row.name, row.base_vertex_count, row.level_count, row.byte_count,
                 row.error.rms / diagonal, row.error.maximum / diagonal);
      std::fflush(stdout);
      if (csv) write_csv(csv, scan.name, arguments.errors[i], row, diagonal);
    };
    std::vector<std::vector<Row>> by_error = nmc_bench::ablate(scan, options);
    for (std::size_t i = 0; i < by_error.size(); ++i) {
      std::optional<Row> last;
      if (!arguments.results.empty()) {
        last = known_result(arguments.results, std::filesystem::path(path).filename().string(),
                            arguments.errors[i], diagonal);
      }
      if (!last) last = nmc_bench::whole_encoder(scan, options.errors[i], arguments.effort);
      options.done(i, *last);
      by_error[i].push_back(*last);
    }
    fmt::print(
        "\n{}: bytes at an RMS error over the diagonal of, and decibels over the open loop at its bytes\n\n",
        scan.name);
    print_table(arguments.errors, by_error);
  }
  if (csv) std::fclose(csv);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "What each part of the encoder is worth: bytes at equal error, one part put in after the other.");
  Arguments arguments;
  app.add_option("mesh", arguments.meshes, "input meshes")->required();
  app.add_option("--rms", arguments.errors, "errors over the diagonal")->capture_default_str();
  app.add_option("--base", arguments.ablation.base_vertex_count, "base vertices of all rows but the last")
      ->capture_default_str();
  app.add_option("--levels", arguments.ablation.level_count, "levels of all rows but the last")
      ->capture_default_str();
  app.add_option("--effort", arguments.effort, "of the last row")->capture_default_str();
  app.add_option("--csv", arguments.csv, "append the rows to this file");
  app.add_option("--results", arguments.results,
                 "take the last row from this file of bench/rd where it is there")
      ->check(CLI::ExistingFile);
  CLI11_PARSE(app, argc, argv);
  try {
    run(arguments);
  } catch (const nmc::Error& error) {
    fmt::print(stderr, "nmc-bench-ablation: {}\n", error.what());
    return static_cast<int>(error.code());
  }
  return 0;
}

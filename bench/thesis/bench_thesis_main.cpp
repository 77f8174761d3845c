// SPDX-License-Identifier: Apache-2.0
// nmc-bench-thesis: the tables and figures of Friedel's thesis, published numbers beside ours.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <map>

#include "bench/thesis/experiment.h"
#include "encoder/core/error.h"

int main(int argc, char** argv) {
  using nmc_bench::Settings;
  const std::map<std::string, std::function<void(const Settings&)>> experiments{
      {"sphere-times", nmc_bench::run_sphere_times}, {"fold-free", nmc_bench::run_fold_free},
      {"collapse", nmc_bench::run_collapse},         {"convergence", nmc_bench::run_convergence},
      {"distortion", nmc_bench::run_distortion},     {"curves", nmc_bench::run_curves},
      {"table-3-1", nmc_bench::run_table_3_1},       {"levels", nmc_bench::run_levels},
      {"zone-sphere", nmc_bench::run_zone_sphere},   {"pictures", nmc_bench::run_pictures},
      {"hierarchies", nmc_bench::run_hierarchies}};

  CLI::App app{
      "Reproduces the tables and figures of the thesis: tables go to standard output as Markdown, tables as "
      "CSV and figures to the output folder"};
  Settings settings;
  const char* corpus = std::getenv("NMC_CORPUS");
  settings.corpus = corpus ? corpus : NMC_SOURCE_DIR "/../shared/corpus";
  settings.output = NMC_SOURCE_DIR "/docs/thesis/figures";
  std::vector<std::string> names;
  app.add_option("experiment", names, "which (default: all)")->check(CLI::IsMember([&] {
    std::vector<std::string> all;
    for (const auto& [name, run] : experiments) all.push_back(name);
    return all;
  }()));
  app.add_option("--corpus", settings.corpus, "folder of the meshes (default: $NMC_CORPUS)");
  app.add_option("--output", settings.output, "folder for the results");
  app.add_option("--model", settings.model, "only models whose name contains this");
  app.add_option(
      "--semi-regular", settings.semi_regular,
      "a mesh with subdivision connectivity, on its own base mesh: one more model for table-3-1 and levels");
  app.add_option("--coast", settings.coast, "coast line, written by bench/thesis/coast_line.py");
  CLI11_PARSE(app, argc, argv);
  if (names.empty())
    for (const auto& [name, run] : experiments) names.push_back(name);
  try {
    std::filesystem::create_directories(settings.output);
    for (const std::string& name : names) {
      fmt::print("\n## {}\n\n", name);
      experiments.at(name)(settings);
    }
  } catch (const nmc::Error& error) {
    fmt::print(stderr, "nmc-bench-thesis: {}\n", error.what());
    return static_cast<int>(error.code());
  } catch (const std::exception& error) {
    fmt::print(stderr, "nmc-bench-thesis: {}\n", error.what());
    return static_cast<int>(nmc::ExitCode::kInternal);
  }
  return 0;
}

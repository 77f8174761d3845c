// SPDX-License-Identifier: Apache-2.0
#include "bench/thesis/experiment.h"

#include <fmt/format.h>

#include <cstdio>
#include <fstream>

#include "encoder/condition/condition.h"
#include "encoder/core/error.h"
#include "encoder/read/mesh_reader.h"

namespace nmc_bench {

nmc::TriangleMesh load_mesh(const Settings& settings, const std::string& file) {
  return load_mesh(settings.corpus + "/" + file);
}

nmc::TriangleMesh load_mesh(const std::string& path) { return nmc::condition(nmc::read_mesh(path), {}).mesh; }

const std::vector<std::string>& genus0_files() {
  static const std::vector<std::string> files{
      "igea.ply",     "amo.off",    "armadillo.obj",     "nefertiti.obj", "horse.ply",  "dilo.off",
      "m1phobos.obj", "pepper.ply", "rgb_nefertiti.off", "bimba.off",     "fandisk.obj"};
  return files;
}

void Table::add(std::vector<std::string> cells) {
  rows_.push_back(std::move(cells));
  // Progress for long experiments; the table itself goes to standard output.
  fmt::print(stderr, "{}\n", fmt::join(rows_.back(), "  "));
}

void Table::print() const {
  fmt::print("| {} |\n|", fmt::join(columns_, " | "));
  for (std::size_t i = 0; i < columns_.size(); ++i) fmt::print("{}", i == 0 ? "---|" : "--:|");
  fmt::print("\n");
  for (const auto& row : rows_) fmt::print("| {} |\n", fmt::join(row, " | "));
  std::fflush(stdout);
}

void Table::write_csv(const std::string& path) const {
  std::ofstream file(path);
  file << fmt::format("{}\n", fmt::join(columns_, ","));
  for (const auto& row : rows_) file << fmt::format("{}\n", fmt::join(row, ","));
  if (!file.flush()) throw nmc::Error(nmc::ExitCode::kInputOutput, path + ": cannot be written");
}

}  // namespace nmc_bench

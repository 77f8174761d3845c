// SPDX-License-Identifier: Apache-2.0
// What the experiments share: where meshes come from, where results go, and clocks.
#ifndef NMC_BENCH_THESIS_EXPERIMENT_H_
#define NMC_BENCH_THESIS_EXPERIMENT_H_

#include <chrono>
#include <ctime>
#include <string>
#include <vector>

#include "encoder/core/triangle_mesh.h"

namespace nmc_bench {

struct Settings {
  std::string corpus;  // folder of the meshes
  std::string output;  // folder for tables, plots and pictures
  std::string coast;   // text file of the coast line, from coast_line.py; empty: that experiment is left out
  std::string model;   // only models whose name contains this; empty: all
  std::string
      semi_regular;  // a mesh with subdivision connectivity, for table-3-1 and levels beside the others
  bool wants(const std::string& name) const { return name.find(model) != std::string::npos; }
};

/// Wall and processor time since construction.
class Stopwatch {
 public:
  double wall_seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - wall_).count();
  }
  double cpu_seconds() const { return static_cast<double>(std::clock() - cpu_) / CLOCKS_PER_SEC; }

 private:
  std::chrono::steady_clock::time_point wall_ = std::chrono::steady_clock::now();
  std::clock_t cpu_ = std::clock();
};

/// A mesh of the corpus, conditioned. Throws nmc::Error where it is missing.
nmc::TriangleMesh load_mesh(const Settings& settings, const std::string& file);

/// Any mesh file, conditioned.
nmc::TriangleMesh load_mesh(const std::string& path);

/// The closed meshes of genus 0 in the corpus, of one component.
const std::vector<std::string>& genus0_files();

/// Collects rows, prints them as a Markdown table and writes them as CSV.
class Table {
 public:
  explicit Table(std::vector<std::string> columns) : columns_(std::move(columns)) {}
  void add(std::vector<std::string> cells);
  void print() const;
  void write_csv(const std::string& path) const;

 private:
  std::vector<std::string> columns_;
  std::vector<std::vector<std::string>> rows_;
};

void run_sphere_times(const Settings& settings);
void run_fold_free(const Settings& settings);
void run_collapse(const Settings& settings);
void run_convergence(const Settings& settings);
void run_distortion(const Settings& settings);
void run_curves(const Settings& settings);
void run_table_3_1(const Settings& settings);
void run_levels(const Settings& settings);
void run_hierarchies(const Settings& settings);
void run_zone_sphere(const Settings& settings);
void run_pictures(const Settings& settings);

}  // namespace nmc_bench

#endif  // NMC_BENCH_THESIS_EXPERIMENT_H_

// SPDX-License-Identifier: Apache-2.0
// nmc-bench-bits FILE...: what the bytes of a stream of one quality layer are spent on.
//
// The integers of the file are coded again by its own models, each time with less to say: what a step takes away is
// what that kind of knowledge costs. In this order: tangential parts are left out, magnitudes become one, signs plus.
// What is left says where coefficients are not zero. Coordinates that are all zero leave the base's connectivity.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "bench/train/integers.h"
#include "encoder/core/error.h"

namespace {

using nmc::bench::CodableMesh;
using nmc::bench::Integers;

CodableMesh::Bits bits_of(const Integers& integers) {
  nmc::BaseMeshModel base_model;
  const auto coefficient_model = std::make_unique<nmc::CoefficientModel>();  // tables of many kilobytes
  return CodableMesh(integers).code(base_model, *coefficient_model);
}

double bytes_of(double bits) { return bits / 8; }

void print_file(const std::string& path) {
  Integers integers = nmc::bench::integers_of_stream(path);
  const auto file_bytes = static_cast<double>(std::filesystem::file_size(path));
  const CodableMesh::Bits all = bits_of(integers);
  fmt::print("{}: {:.0f} bytes, {} base vertices, {} levels\n\n", path, file_bytes, integers.vertex_count,
             integers.levels.size());
  fmt::print("| | bytes | % |\n|---|--:|--:|\n");
  const auto row = [&](const std::string& name, double bytes) {
    fmt::print("| {} | {:.0f} | {:.1f} |\n", name, bytes, 100 * bytes / file_bytes);
  };
  Integers base_only = integers;
  base_only.levels.clear();
  for (std::int32_t& x : base_only.coordinates) x = 0;
  const double connectivity = bits_of(base_only).base;
  row("header, layer table, frames of chunks", file_bytes - bytes_of(all.base + all.coefficients));
  row("base mesh: connectivity", bytes_of(connectivity));
  row("base mesh: coordinates", bytes_of(all.base - connectivity));

  // Level by level: coding one more of them.
  struct Kinds {
    double where = 0, signs = 0, magnitudes = 0, tangential = 0;
    std::size_t nonzero = 0, count = 0;
  };
  std::vector<Kinds> levels(integers.levels.size());
  Integers prefix = integers;
  prefix.levels.clear();
  Integers normal = prefix, units = prefix, places = prefix;
  CodableMesh::Bits before_all, before_normal, before_units, before_places;
  for (std::size_t l = 0; l < levels.size(); ++l) {
    Integers::Level level = integers.levels[l];
    Kinds& kinds = levels[l];
    kinds.count = level.normal.size();
    prefix.levels.push_back(level);
    level.tangential.clear();
    normal.levels.push_back(level);
    for (std::int32_t& c : level.normal) {
      kinds.nonzero += c != 0;
      c = (c > 0) - (c < 0);
    }
    units.levels.push_back(level);
    for (std::int32_t& c : level.normal) c = std::abs(c);
    places.levels.push_back(level);
    const auto added = [](const Integers& coded, CodableMesh::Bits& before) {
      const CodableMesh::Bits now = bits_of(coded);
      const double more = now.coefficients - before.coefficients;
      before = now;
      return more;
    };
    const double of_all = added(prefix, before_all), of_normal = added(normal, before_normal);
    const double of_units = added(units, before_units), of_places = added(places, before_places);
    kinds.where = of_places;
    kinds.signs = of_units - of_places;
    kinds.magnitudes = of_normal - of_units;
    kinds.tangential = of_all - of_normal;
  }
  for (std::size_t l = 0; l < levels.size(); ++l) {
    const Kinds& kinds = levels[l];
    row(fmt::format("level {}: which of {} coefficients are not zero ({})", l, kinds.count, kinds.nonzero),
        bytes_of(kinds.where));
    row(fmt::format("level {}: signs", l), bytes_of(kinds.signs));
    row(fmt::format("level {}: magnitudes", l), bytes_of(kinds.magnitudes));
    row(fmt::format("level {}: tangential parts", l), bytes_of(kinds.tangential));
  }
  fmt::print("\n");
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"What the bytes of a stream of one quality layer are spent on, as Markdown."};
  std::vector<std::string> files;
  app.add_option("FILE", files)->required();
  CLI11_PARSE(app, argc, argv);
  try {
    for (const std::string& file : files) print_file(file);
  } catch (const nmc::Error& error) {
    fmt::print(stderr, "nmc-bench-bits: {}\n", error.what());
    return static_cast<int>(error.code());
  }
  return 0;
}

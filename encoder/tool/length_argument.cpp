// SPDX-License-Identifier: Apache-2.0
#include "encoder/tool/length_argument.h"

#include <fast_float/fast_float.h>

#include <array>
#include <cmath>
#include <utility>

#include "encoder/core/error.h"

namespace nmc {

namespace {

std::pair<double, std::string> split_number(const std::string& text) {
  double number = 0;
  const auto [end, failure] = fast_float::from_chars(text.data(), text.data() + text.size(), number);
  if (failure != std::errc() || !std::isfinite(number) || number < 0) {
    throw Error(ExitCode::kUsage, "'" + text + "' does not start with a number that is not negative");
  }
  return {number, std::string(end, text.data() + text.size())};
}

double metres_per_unit(Units units) {
  constexpr std::array<double, 7> kMetres = {0, 1e-3, 1e-2, 1, 0.0254, 0.3048, 1e3};
  return kMetres[static_cast<std::size_t>(units)];
}

}  // namespace

Units parse_units(const std::string& text) {
  constexpr std::array<std::pair<const char*, Units>, 6> kNames = {{{"mm", Units::kMillimetre},
                                                                    {"cm", Units::kCentimetre},
                                                                    {"m", Units::kMetre},
                                                                    {"in", Units::kInch},
                                                                    {"ft", Units::kFoot},
                                                                    {"km", Units::kKilometre}}};
  for (const auto& [name, units] : kNames) {
    if (text == name) return units;
  }
  throw Error(ExitCode::kUsage, "unknown units '" + text + "': mm, cm, m, in, ft or km");
}

LengthArgument parse_length(const std::string& text) {
  const auto [number, suffix] = split_number(text);
  LengthArgument length;
  length.number = number;
  if (suffix == "%")
    length.is_percent = true;
  else if (!suffix.empty())
    length.units = parse_units(suffix);
  return length;
}

double length_in_input_units(const LengthArgument& length, Units input_units, double diagonal) {
  if (length.is_percent) return length.number / 100 * diagonal;
  if (length.units == Units::kUnknown) return length.number;
  if (input_units == Units::kUnknown) {
    throw Error(ExitCode::kUsage,
                "a length with units needs --units, which says what the input's numbers mean");
  }
  return length.number * metres_per_unit(length.units) / metres_per_unit(input_units);
}

double parse_size(const std::string& text) {
  const auto [number, suffix] = split_number(text);
  constexpr std::array<std::pair<const char*, double>, 9> kFactors = {{{"", 1},
                                                                       {"B", 1},
                                                                       {"kB", 1e3},
                                                                       {"KB", 1e3},
                                                                       {"MB", 1e6},
                                                                       {"GB", 1e9},
                                                                       {"KiB", 1024},
                                                                       {"MiB", 1048576},
                                                                       {"GiB", 1073741824}}};
  for (const auto& [name, factor] : kFactors) {
    if (suffix == name) return number * factor;
  }
  throw Error(ExitCode::kUsage, "unknown size '" + text + "': a number with B, kB, MB, GB, KiB, MiB or GiB");
}

}  // namespace nmc

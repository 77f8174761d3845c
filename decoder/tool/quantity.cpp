// SPDX-License-Identifier: Apache-2.0
#include "decoder/tool/quantity.h"

#include <charconv>
#include <cmath>
#include <cstdio>
#include <string_view>
#include <utility>

#include "decoder/tool/tool_error.h"

namespace nmc {

namespace {

/// Splits "1.5MiB" into a number that is not negative and what follows it.
double leading_number(const std::string& text, std::string_view& suffix) {
  double number = 0;
  const std::from_chars_result parsed = std::from_chars(text.data(), text.data() + text.size(), number);
  if (parsed.ec != std::errc() || !std::isfinite(number) || number < 0) {
    throw ToolError(ToolExit::kUsage, "'" + text + "' is not a number with an optional unit");
  }
  suffix = std::string_view(parsed.ptr, static_cast<std::size_t>(text.data() + text.size() - parsed.ptr));
  return number;
}

struct Unit {
  const char* name;
  nmc_units units;
  double metres;
};

constexpr Unit kUnits[] = {{"mm", NMC_UNITS_MILLIMETRE, 0.001}, {"cm", NMC_UNITS_CENTIMETRE, 0.01},
                           {"m", NMC_UNITS_METRE, 1},           {"in", NMC_UNITS_INCH, 0.0254},
                           {"ft", NMC_UNITS_FOOT, 0.3048},      {"km", NMC_UNITS_KILOMETRE, 1000}};

}  // namespace

double parse_length(const std::string& text, const nmc_info& info) {
  std::string_view suffix;
  const double number = leading_number(text, suffix);
  if (suffix.empty()) return number;
  if (suffix == "%") return number / 100 * info.diagonal;
  for (const Unit& unit : kUnits) {
    if (suffix != unit.name) continue;
    for (const Unit& own : kUnits) {
      if (own.units == info.units) return number * unit.metres / own.metres;
    }
    throw ToolError(ToolExit::kUsage, "'" + text +
                                          "': the stream does not say in which units it is; give a plain "
                                          "number in its units, or percent of its diagonal");
  }
  throw ToolError(ToolExit::kUsage, "'" + text + "': unknown unit; use %, mm, cm, m, in, ft or km");
}

double parse_size(const std::string& text) {
  std::string_view suffix;
  const double number = leading_number(text, suffix);
  constexpr std::pair<const char*, double> kSuffixes[] = {
      {"", 1},     {"B", 1},       {"kB", 1e3},      {"KB", 1e3},        {"MB", 1e6},
      {"GB", 1e9}, {"KiB", 1024.}, {"MiB", 1048576}, {"GiB", 1073741824}};
  for (const auto& [name, factor] : kSuffixes) {
    if (suffix == name) return number * factor;
  }
  throw ToolError(ToolExit::kUsage, "'" + text + "': unknown unit; use B, kB, MB, GB, KiB, MiB or GiB");
}

const char* units_name(nmc_units units) {
  for (const Unit& unit : kUnits) {
    if (unit.units == units) return unit.name;
  }
  return "";
}

std::string bytes_text(std::uint64_t bytes) {
  constexpr const char* kNames[] = {"kB", "MB", "GB", "TB"};
  if (bytes < 1000) return std::to_string(bytes) + (bytes == 1 ? " byte" : " bytes");
  double value = static_cast<double>(bytes) / 1000;
  int i = 0;
  for (; value >= 999.5 && i < 3; ++i) value /= 1000;
  char text[40];
  std::snprintf(text, sizeof text, "%.3g %s", value, kNames[i]);
  return text;
}

std::string length_text(double length, nmc_units units) {
  char text[40];
  std::snprintf(text, sizeof text, "%.3g%s%s", length, *units_name(units) ? " " : "", units_name(units));
  return text;
}

std::string hash_text(std::uint64_t hash) {
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash));
  return text;
}

}  // namespace nmc

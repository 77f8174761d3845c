// SPDX-License-Identifier: Apache-2.0
#include "bench/peers/result_table.h"

#include <fmt/core.h>

#include <fstream>

#include "encoder/core/error.h"

namespace nmc::bench {
namespace {

constexpr const char* kHeader =
    "mesh,peer,settings,bytes,rms,max,normal_degrees,triangles,encode_seconds,decode_seconds\n";

}  // namespace

ResultTable::ResultTable(const std::string& path) : path_(path) {
  std::ifstream existing(path);
  std::string line;
  bool empty = true;
  while (std::getline(existing, line)) {
    empty = false;
    const std::size_t first = line.find(',');
    const std::size_t second = line.find(',', first + 1);
    if (second != std::string::npos)
      present_.emplace(line.substr(0, first), line.substr(first + 1, second - first - 1));
  }
  if (!empty) return;
  std::ofstream created(path);
  created << kHeader;
  if (!created) throw Error(ExitCode::kInputOutput, path + ": cannot be written");
}

bool ResultTable::contains(const std::string& mesh, const std::string& peer) const {
  return present_.count({mesh, peer}) != 0;
}

void ResultTable::append(const std::string& mesh, const std::string& peer,
                         const std::vector<ResultRow>& rows) {
  std::string text;
  for (const ResultRow& row : rows) {
    text += fmt::format("{},{},{},{},{:.6g},{:.6g},{:.4g},{},{:.4g},{:.4g}\n", mesh, peer, row.settings,
                        row.bytes, row.rms, row.maximum, row.normal_degrees, row.triangles,
                        row.encode_seconds, row.decode_seconds);
  }
  std::ofstream file(path_, std::ios::app);
  file << text << std::flush;
  if (!file) throw Error(ExitCode::kInputOutput, path_ + ": cannot be written");
  present_.emplace(mesh, peer);
}

}  // namespace nmc::bench

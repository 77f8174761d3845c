// SPDX-License-Identifier: Apache-2.0
// The CSV file of peer results: one row per mesh, peer and setting; doubles as the memory of an interrupted
// run.
#ifndef NMC_BENCH_PEERS_RESULT_TABLE_H_
#define NMC_BENCH_PEERS_RESULT_TABLE_H_

#include <cstddef>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace nmc::bench {

/// Errors relative to the bounding-box diagonal of the mesh; seconds are wall clock.
struct ResultRow {
  std::string settings;
  std::size_t bytes = 0;
  double rms = 0, maximum = 0, normal_degrees = 0;
  std::size_t triangles = 0;
  double encode_seconds = 0, decode_seconds = 0;
};

class ResultTable {
 public:
  /// Opens or creates the file at `path`. Throws Error(kInputOutput).
  explicit ResultTable(const std::string& path);

  /// Whether rows of this mesh and peer are already there.
  bool contains(const std::string& mesh, const std::string& peer) const;

  /// Appends all rows of one mesh and peer in one write, so that an interrupted run leaves whole groups only.
  void append(const std::string& mesh, const std::string& peer, const std::vector<ResultRow>& rows);

 private:
  std::string path_;
  std::set<std::pair<std::string, std::string>> present_;
};

}  // namespace nmc::bench

#endif  // NMC_BENCH_PEERS_RESULT_TABLE_H_

// SPDX-License-Identifier: Apache-2.0
// format-spec.md as a test sees it: its example blocks, its tables, and the text under a heading.
#ifndef NMC_TESTS_SPEC_SPEC_DOCUMENT_H_
#define NMC_TESTS_SPEC_SPEC_DOCUMENT_H_

#include <catch2/catch.hpp>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace nmc::test {

using Words = std::vector<std::string>;

inline Words words_of(const std::string& text) {
  std::istringstream in(text);
  Words words;
  for (std::string word; in >> word;) words.push_back(word);
  return words;
}

/// One ```example KIND block.
struct Example {
  std::string kind;
  std::vector<std::string> lines;
};

class SpecDocument {
 public:
  SpecDocument() {
    std::ifstream file(NMC_SOURCE_DIR "/format-spec.md");
    REQUIRE(file.good());
    for (std::string line; std::getline(file, line);) lines_.push_back(line);
  }

  std::vector<Example> examples() const {
    std::vector<Example> result;
    bool is_inside = false;
    for (const std::string& line : lines_) {
      if (line.rfind("```example ", 0) == 0) {
        result.push_back({line.substr(11), {}});
        is_inside = true;
      } else if (line.rfind("```", 0) == 0) {
        is_inside = false;
      } else if (is_inside) {
        result.back().lines.push_back(line);
      }
    }
    return result;
  }

  /// The lines from the heading that begins with `heading` (hashes included) to the next heading.
  std::vector<std::string> under(const std::string& heading) const {
    std::vector<std::string> result;
    bool is_inside = false;
    for (const std::string& line : lines_) {
      if (!line.empty() && line[0] == '#') is_inside = line.rfind(heading, 0) == 0;
      if (is_inside) result.push_back(line);
    }
    INFO(heading);
    REQUIRE(!result.empty());
    return result;
  }

  /// Cells of the rows of the tables under a heading, without their heads and the ticks around names.
  std::vector<Words> table(const std::string& heading) const {
    std::vector<Words> rows;
    int line_in_table = 0;
    for (const std::string& line : under(heading)) {
      line_in_table = line.rfind("|", 0) == 0 ? line_in_table + 1 : 0;
      if (line_in_table <= 2) continue;  // the head and the rule below it
      Words cells;
      std::string cell;
      for (std::size_t i = 1; i < line.size(); ++i) {
        if (line[i] == '|' && line[i - 1] != '\\') {
          const std::size_t first = cell.find_first_not_of(" `"), last = cell.find_last_not_of(" `");
          cells.push_back(first == std::string::npos ? "" : cell.substr(first, last - first + 1));
          cell.clear();
        } else {
          cell += line[i];
        }
      }
      rows.push_back(cells);
    }
    return rows;
  }

 private:
  std::vector<std::string> lines_;
};

}  // namespace nmc::test

#endif  // NMC_TESTS_SPEC_SPEC_DOCUMENT_H_

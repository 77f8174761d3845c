// SPDX-License-Identifier: Apache-2.0
// The tables of format-spec.md against the constants of the code.
#include <catch2/catch.hpp>
#include <map>
#include <regex>

#include "libnmc/common/attribute_coder.h"
#include "libnmc/common/base_mesh_coder.h"
#include "libnmc/common/coefficient_coder.h"
#include "libnmc/common/format.h"
#include "libnmc/common/trained_states.h"
#include "libnmc/include/nmc/nmc.h"
#include "tests/spec/spec_document.h"

using namespace nmc;
using namespace nmc::test;

namespace {

/// "2^16 bytes", "2^28 - 1", "14": the number.
std::int64_t number_in(const std::string& text) {
  std::smatch match;
  if (std::regex_search(text, match, std::regex(R"(^(\d+)\^(\d+)( - 1)?)"))) {
    std::int64_t value = 1;
    for (int i = std::stoi(match[2]); i > 0; --i) value *= std::stoll(match[1]);
    return value - (match[3].matched ? 1 : 0);
  }
  return std::stoll(text);
}

/// All numbers of the lines between `first` and the line that holds the end mark.
std::vector<double> numbers_after(const std::vector<std::string>& lines, const std::string& first) {
  std::string text;
  bool is_inside = false;
  for (const std::string& line : lines) {
    const std::size_t start = line.find(first);
    if (start != std::string::npos) {
      is_inside = true;
      text += line.substr(line.find(':', start) + 1) + " ";
    } else if (is_inside) {
      text += line + " ";
    }
    if (is_inside && !line.empty() && line.back() == '.') break;
  }
  std::vector<double> numbers;
  const std::regex pattern(R"(\d+(\.\d+)?)");
  for (std::sregex_iterator it(text.begin(), text.end(), pattern), end; it != end; ++it)
    numbers.push_back(std::stod(it->str()));
  return numbers;
}

std::string read_source(const std::string& path) {
  std::ifstream file(NMC_SOURCE_DIR "/" + path);
  REQUIRE(file.good());
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

}  // namespace

TEST_CASE("spec: the table of limits is that of the code", "[spec]") {
  const std::map<std::string, std::int64_t> code = {
      {"header", kMaximumHeaderSize},
      {"chunk", kMaximumChunkSize},
      {"levels", kMaximumLevelCount},
      {"quality layers", kMaximumLayerCount},
      {"regions", kMaximumRegionCount},
      {"rows", kMaximumTableSize},
      {"vertices of a level", static_cast<std::int64_t>(kMaximumVertexCount)},
      {"faces around a base vertex", kMaximumValence},
      {"base coordinate", kMaximumBaseCoordinate},
      {"coefficient", kMaximumMagnitude},
      {"attributes", kMaximumAttributeCount},
      {"correction of an attribute", kMaximumCorrection},
  };
  std::size_t found = 0;
  for (const Words& row : SpecDocument().table("## 8 Limits")) {
    const auto entry = code.find(row.at(0));
    INFO(row.at(0));
    if (entry == code.end()) continue;
    CHECK(number_in(row.at(1)) == entry->second);
    ++found;
  }
  CHECK(found >= 9);
}

TEST_CASE("spec: the bounds of counts against bytes are those of the code", "[spec]") {
  std::string text;
  for (const std::string& line : SpecDocument().under("### 8.2")) text += line + " ";
  CHECK(text.find("F <= " + std::to_string(kFreeBaseFaces) + " + " + std::to_string(kBaseFacesPerByte) +
                  " n") != std::string::npos);
  CHECK(text.find("may hold " + std::to_string(kFreeVertices) + " + " + std::to_string(kVerticesPerByte) +
                  " n vertices") != std::string::npos);
  CHECK(text.find("more than " + std::to_string(kFreeValues) + " + " + std::to_string(kValuesPerByte) + " n;") !=
        std::string::npos);
}

TEST_CASE("spec: types of chunks are those of the code", "[spec]") {
  const std::map<std::string, ChunkType> code = {{"base mesh", ChunkType::kBaseMesh},
                                                 {"base correction", ChunkType::kBaseCorrection},
                                                 {"geometry", ChunkType::kGeometry},
                                                 {"attribute", ChunkType::kAttribute},
                                                 {"region", ChunkType::kRegion},
                                                 {"metadata", ChunkType::kMetadata}};
  const std::vector<Words> rows = SpecDocument().table("### 3.2");
  CHECK(rows.size() == code.size());
  for (const Words& row : rows) {
    INFO(row.at(1));
    REQUIRE(code.count(row.at(1)) == 1);
    CHECK(std::stoi(row.at(0), nullptr, 16) == static_cast<int>(code.at(row.at(1))));
  }
}

TEST_CASE("spec: codes of errors are those of nmc.h", "[spec]") {
  for (const Words& row : SpecDocument().table("### 1.3")) {
    CHECK(nmc_status_name(static_cast<nmc_status>(std::stoi(row.at(1)))) == "NMC_ERR_" + row.at(0));
  }
}

TEST_CASE("spec: tables B.1 and B.3 and the energy classes are those of the code", "[spec]") {
  const SpecDocument document;
  const std::vector<std::string> tables = document.under("## Appendix B");
  const std::vector<double> squashed = numbers_after(tables, "B.1 squash");
  REQUIRE(squashed.size() == 65);
  for (std::size_t i = 0; i < 65; ++i) CHECK(squashed[i] == mixing_internal::kSquash[i]);

  std::vector<double> roots = numbers_after(tables, "B.3 2^(k/8), k = 0 ... 7");
  REQUIRE(roots.size() == 8);
  for (std::size_t k = 0; k < 8; ++k)
    CHECK(roots[k] == step_from_code(1.0, static_cast<std::uint8_t>(64 + k)));

  std::string text;
  for (const std::string& line : document.under("#### 5.3.1")) text += line + " ";
  std::smatch match;
  REQUIRE(std::regex_search(text, match, std::regex(R"(number of bounds ([0-9, ]+) that it reaches)")));
  std::istringstream bounds(match[1]);
  int reached = 0;
  for (std::string bound; std::getline(bounds, bound, ',');) {
    const int b = std::stoi(bound);
    CHECK(coefficient_internal::energy_class(b - 1) == reached);
    CHECK(coefficient_internal::energy_class(b) == ++reached);
  }
  CHECK(reached == 10);
}

TEST_CASE("spec: limits of counts are those of the code", "[spec]") {
  std::string text;
  for (const std::string& line : SpecDocument().under("#### 5.2.1")) text += line + " ";
  CHECK(text.find("its limit: " + std::to_string(kSignificanceCountLimit) + " for significance") !=
        std::string::npos);
  CHECK(text.find(std::to_string(kMagnitudeCountLimit) + " for everything else") != std::string::npos);
}

TEST_CASE("spec: the sizes of the context tables of A.2 to A.5 are those of the code", "[spec]") {
  const std::string header = read_source("libnmc/common/coefficient_coder.h");
  const std::map<std::string, std::string> structures = {{"### A.2", "BlockStates"},
                                                         {"### A.3", "SignificanceStates"},
                                                         {"### A.4", "SignStates"},
                                                         {"### A.5", "MagnitudeStates"}};
  const std::map<std::string, std::string> constants = {
      {"kLevelClasses", "8"}, {"kKindCount", "4"}, {"kUnary", "14"}};
  const SpecDocument document;
  for (const auto& [heading, name] : structures) {
    const std::size_t begin = header.find("struct " + name + " {");
    REQUIRE(begin != std::string::npos);
    const std::string body = header.substr(begin, header.find("};", begin) - begin);
    // "by_energy[kLevelClasses][kKindCount][11]" and the like, as "8 4 11"
    std::map<std::string, std::string> sizes;
    const std::regex member(R"((\w+)((\[\w+\])+);)");
    for (std::sregex_iterator it(body.begin(), body.end(), member), end; it != end; ++it) {
      std::string text = (*it)[2];
      std::string joined;
      const std::regex index(R"(\[(\w+)\])");
      for (std::sregex_iterator i(text.begin(), text.end(), index), last; i != last; ++i) {
        const std::string size = (*i)[1];
        if (!joined.empty()) joined += " ";
        joined += constants.count(size) ? constants.at(size) : size;
      }
      sizes[(*it)[1]] = joined;
    }
    const std::vector<Words> rows = document.table(heading);
    INFO(name);
    CHECK(rows.size() == sizes.size());
    for (const Words& row : rows) {
      INFO(row.at(0));
      CHECK(sizes[row.at(0)] == row.at(1));
    }
  }
}

TEST_CASE("spec: the trained states of appendix D are those of the code", "[spec]") {
  const SpecDocument document;
  const auto text_under = [&](const std::string& heading) {
    std::string text;
    bool is_inside = false;
    for (const std::string& line : document.under(heading)) {
      if (line.rfind("```", 0) == 0)
        is_inside = !is_inside;
      else if (is_inside)
        text += line;
    }
    return text;
  };
  CHECK(text_under("### D.1") == kTrainedBaseStates);
  CHECK(text_under("### D.2") == kTrainedCoefficientStates);
  std::size_t number = 0;
  for (const Words& row : document.table("### D.3")) {
    INFO(row.at(0));
    const Words weights = words_of(row.at(1));
    for (std::size_t i = 0; i < weights.size(); ++i)
      CHECK(std::stoi(weights[i]) == kTrainedWeights[number][i]);
    ++number;
  }
  CHECK(number == 12);
}

// SPDX-License-Identifier: Apache-2.0
#include "encoder/tool/batch.h"

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "encoder/core/error.h"
#include "encoder/read/mesh_reader.h"

namespace nmc {

namespace {

namespace fs = std::filesystem;

bool is_mesh_file(const fs::directory_entry& entry) {
  if (!entry.is_regular_file()) return false;
  const std::string ending = entry.path().extension().string();
  return ending.size() > 1 && mesh_format_from_name(ending.substr(1)).has_value();
}

std::vector<std::string> meshes_of_folder(const fs::path& folder) {
  std::vector<std::string> names;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (is_mesh_file(entry)) names.push_back(entry.path().string());
  }
  std::sort(names.begin(), names.end());  // the system's order is not defined
  return names;
}

std::vector<std::string> lines_of_file(const fs::path& list) {
  std::ifstream file(list);
  if (!file) throw Error(ExitCode::kInputOutput, list.string() + ": cannot be opened");
  std::vector<std::string> names;
  for (std::string line; std::getline(file, line);) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line.empty() || line.front() == '#') continue;
    names.push_back((list.parent_path() / line).string());
  }
  return names;
}

}  // namespace

std::vector<std::string> batch_inputs(const std::string& list_or_folder) {
  std::error_code error;
  const bool is_folder = fs::is_directory(list_or_folder, error);
  std::vector<std::string> names =
      is_folder ? meshes_of_folder(list_or_folder) : lines_of_file(list_or_folder);
  if (names.empty()) throw Error(ExitCode::kUsage, list_or_folder + ": names no mesh file");
  return names;
}

}  // namespace nmc

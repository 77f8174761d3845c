// SPDX-License-Identifier: Apache-2.0
#include "encoder/domain/parameterize.h"

namespace nmc {

std::vector<Parameterization> parameterize(const TriangleMesh& mesh, const std::vector<int>& base_sizes,
                                           const CollapseOptions& collapse_options,
                                           const RelaxationOptions& relaxation_options,
                                           const Progress& progress) {
  const CollapseHistory history = maps_collapse(mesh, base_sizes, collapse_options, progress);
  std::vector<Parameterization> results;
  results.reserve(base_sizes.size());
  for (std::size_t i = 0; i < base_sizes.size(); ++i)
    results.push_back(relax(history, i, relaxation_options, progress));
  return results;
}

}  // namespace nmc

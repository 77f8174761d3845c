// SPDX-License-Identifier: Apache-2.0
#include "encoder/condition/degenerate.h"

#include <fmt/format.h>

#include <algorithm>

#include "encoder/condition/parity_sets.h"

namespace nmc::conditioning {

namespace {

Triangle sorted(Triangle t) {
  std::sort(t.begin(), t.end());
  return t;
}

/// Whether two orderings of the same three vertices run around them the same way.
bool same_orientation(const Triangle& a, const Triangle& b) {
  const auto at = static_cast<std::size_t>(std::find(b.begin(), b.end(), a[0]) - b.begin());
  return b[(at + 1) % 3] == a[1];
}

/// For each triangle: the patch it belongs to in the file's own connectivity (its lowest triangle), and
/// whether that patch is a closed, orientable manifold there.
struct Patches {
  std::vector<std::uint32_t> of_triangle;
  std::vector<std::uint8_t> is_closed;        // at the patch's lowest triangle
  std::vector<std::uint32_t> triangle_count;  // at the patch's lowest triangle

  Patches(const std::vector<Triangle>& stored, std::size_t vertex_count)
      : of_triangle(stored.size()), is_closed(stored.size(), 1), triangle_count(stored.size(), 0) {
    const EdgeGroups edges(stored, vertex_count);
    ParitySets sets(stored.size());
    std::vector<std::uint32_t> contradictions;
    edges.for_each([&](std::span<const GroupedHalfEdge> group) {
      if (group.size() != 2) return;
      const std::uint32_t a = group[0].half_edge(), b = group[1].half_edge();
      if (!sets.unite(a / 3, b / 3, tail_of(stored, a) == tail_of(stored, b)))
        contradictions.push_back(a / 3);
    });
    for (std::uint32_t t = 0; t < stored.size(); ++t) {
      of_triangle[t] = sets.find(t).root;
      ++triangle_count[of_triangle[t]];
    }
    for (const std::uint32_t t : contradictions) is_closed[of_triangle[t]] = 0;
    edges.for_each([&](std::span<const GroupedHalfEdge> group) {
      if (group.size() != 2)
        for (const GroupedHalfEdge& entry : group) is_closed[of_triangle[entry.half_edge() / 3]] = 0;
    });
  }
};

}  // namespace

void drop_degenerate(WorkingMesh& mesh) {
  const std::size_t first = [&] {
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const Triangle& c = mesh.triangles[t];
      if (c[0] == c[1] || c[1] == c[2] || c[2] == c[0]) return t;
    }
    return mesh.triangles.size();
  }();
  if (first == mesh.triangles.size()) return;
  mesh.note(Defect::kDegenerate,
            [&] { return fmt::format("triangle {} has two corners at the same point", mesh.source[first]); });
  mesh.drop([&](std::size_t t) {
    const Triangle& c = mesh.triangles[t];
    return c[0] == c[1] || c[1] == c[2] || c[2] == c[0] ? TriangleFate::kDegenerate : TriangleFate::kKept;
  });
}

std::size_t drop_duplicates(WorkingMesh& mesh, const EdgeGroups& edges) {
  // Triangles with the same corners share all three edges. Each set is seen exactly once at the edge between
  // its two lower vertices, where its apex is the highest vertex.
  std::vector<std::vector<std::uint32_t>> duplicate_sets;
  std::vector<std::uint32_t> candidates;
  edges.for_each([&](std::span<const GroupedHalfEdge> group) {
    if (group.size() < 2) return;
    candidates.clear();
    for (const GroupedHalfEdge& entry : group)
      if (apex_of(mesh.triangles, entry.half_edge()) > entry.higher_vertex())
        candidates.push_back(entry.half_edge());
    if (candidates.size() < 2) return;
    std::sort(candidates.begin(), candidates.end(), [&](std::uint32_t a, std::uint32_t b) {
      const std::uint32_t apex_a = apex_of(mesh.triangles, a), apex_b = apex_of(mesh.triangles, b);
      return apex_a != apex_b ? apex_a < apex_b : a < b;
    });
    for (std::size_t i = 0; i < candidates.size();) {
      std::size_t j = i + 1;
      while (j < candidates.size() &&
             apex_of(mesh.triangles, candidates[j]) == apex_of(mesh.triangles, candidates[i]))
        ++j;
      if (j - i > 1) {
        std::vector<std::uint32_t> set;
        for (std::size_t k = i; k < j; ++k) set.push_back(candidates[k] / 3);
        duplicate_sets.push_back(std::move(set));
      }
      i = j;
    }
  });
  if (duplicate_sets.empty()) return 0;

  const bool all_by_index = std::all_of(duplicate_sets.begin(), duplicate_sets.end(), [&](const auto& set) {
    return std::all_of(set.begin(), set.end(), [&](std::uint32_t t) {
      return sorted(mesh.stored[t]) == sorted(mesh.stored[set[0]]);
    });
  });
  std::vector<std::uint8_t> is_protected(mesh.triangles.size(), 0);
  if (!all_by_index) {
    const Patches patches(mesh.stored, mesh.positions.size());
    std::vector<std::uint32_t> repeated(mesh.triangles.size(),
                                        0);  // triangles of a patch that have an earlier copy
    for (const auto& set : duplicate_sets)
      for (std::size_t i = 1; i < set.size(); ++i) ++repeated[patches.of_triangle[set[i]]];
    for (const auto& set : duplicate_sets)
      for (const std::uint32_t t : set) {
        const std::uint32_t patch = patches.of_triangle[t];
        is_protected[t] = patches.is_closed[patch] && repeated[patch] < patches.triangle_count[patch];
      }
  }

  std::vector<TriangleFate> verdict(mesh.triangles.size(), TriangleFate::kKept);
  for (const auto& set : duplicate_sets) {
    const auto first_protected =
        std::find_if(set.begin(), set.end(), [&](std::uint32_t t) { return is_protected[t] != 0; });
    const std::uint32_t kept = first_protected != set.end() ? *first_protected : set[0];
    for (std::size_t i = 0; i < set.size(); ++i) {
      const std::uint32_t t = set[i];
      if (t == kept) continue;
      // Two triangles on the very same stored vertices can never both be part of a manifold.
      const auto is_stored_like = [&](std::uint32_t earlier) {
        return sorted(mesh.stored[earlier]) == sorted(mesh.stored[t]);
      };
      if (is_protected[t] &&
          std::none_of(set.begin(), set.begin() + static_cast<std::ptrdiff_t>(i), is_stored_like))
        continue;
      verdict[t] = same_orientation(mesh.triangles[kept], mesh.triangles[t])
                       ? TriangleFate::kDuplicate
                       : TriangleFate::kOppositeDuplicate;
    }
  }
  for (const TriangleFate fate : {TriangleFate::kDuplicate, TriangleFate::kOppositeDuplicate}) {
    const auto first = std::find(verdict.begin(), verdict.end(), fate);
    if (first == verdict.end()) continue;
    const bool same = fate == TriangleFate::kDuplicate;
    mesh.note(same ? Defect::kDuplicate : Defect::kOppositeDuplicate, [&] {
      return fmt::format("triangle {} has the corners of an earlier triangle in {} orientation",
                         mesh.source[static_cast<std::size_t>(first - verdict.begin())],
                         same ? "the same" : "opposite");
    });
  }
  return mesh.drop([&](std::size_t t) { return verdict[t]; });
}

}  // namespace nmc::conditioning

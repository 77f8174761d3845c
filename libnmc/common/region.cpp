// SPDX-License-Identifier: Apache-2.0
#include "libnmc/common/region.h"

namespace nmc {

namespace {

/// Heap sort: in place, and never more than O(n log n), whoever wrote the stream.
NMC_SELDOM void sort_numbers(std::uint32_t* numbers, std::size_t count) {
  for (std::size_t unsorted = count + count / 2; unsorted > 1;) {
    // Above `count` the heap is built, from its last parent up; below, its largest goes to the end.
    --unsorted;
    std::size_t at = 0, end = unsorted;
    if (unsorted >= count) {
      at = unsorted - count;
      end = count;
    } else {
      const std::uint32_t largest = numbers[0];
      numbers[0] = numbers[unsorted];
      numbers[unsorted] = largest;
    }
    const std::uint32_t sinking = numbers[at];
    for (std::size_t child; (child = 2 * at + 1) < end; at = child) {
      if (child + 1 < end && numbers[child + 1] > numbers[child]) ++child;
      if (numbers[child] <= sinking) break;
      numbers[at] = numbers[child];
    }
    numbers[at] = sinking;
  }
}

}  // namespace

NMC_SELDOM Status RegionPartition::build(const LevelTopology& base, std::uint32_t region_count, Memory* memory) {
  const std::uint32_t face_count = base.face_count;
  Array<std::uint32_t> distance(memory), queue(memory);
  if (!distance.assign(face_count, kNone) || !queue.resize_unset(face_count) || !region_of_face.resize(face_count) ||
      !faces.resize_unset(face_count) || !rank_of_face.resize_unset(face_count)) {
    return no_memory();
  }
  for (std::uint32_t region = 0; region < region_count; ++region) {
    std::uint32_t seed = 0;
    for (std::uint32_t f = 1; f < face_count; ++f)
      if (distance[f] > distance[seed]) seed = f;
    // Only faces that come nearer are passed on, so a face is visited once for each time it changes hands. None
    // is in the queue twice, since the first distance of a breadth-first walk is the least.
    std::size_t head = 0, tail = 1;
    queue[0] = seed;
    distance[seed] = 0;
    region_of_face[seed] = region;
    while (head < tail) {
      const std::uint32_t f = queue[head++];
      for (std::uint32_t k = 0; k < 3; ++k) {
        const std::uint32_t next = base.face_across(base.face_edges[std::size_t{3} * f + k], f);
        if (next == kNone || distance[next] <= distance[f] + 1) continue;
        distance[next] = distance[f] + 1;
        region_of_face[next] = region;
        queue[tail++] = next;
      }
    }
  }
  for (std::uint32_t& first : first_face) first = 0;
  for (std::uint32_t f = 0; f < face_count; ++f) rank_of_face[f] = first_face[region_of_face[f] + 1]++;
  for (std::uint32_t region = 0; region < region_count; ++region) first_face[region + 1] += first_face[region];
  for (std::uint32_t f = 0; f < face_count; ++f) faces[first_face[region_of_face[f]] + rank_of_face[f]] = f;
  return ok_status();
}

NMC_SELDOM Status RegionLevel::extract(const LevelTopology& base, const RegionPartition& partition,
                                       std::uint32_t region, Array<std::uint32_t>& scratch) {
  const std::uint32_t* const faces = partition.faces.data() + partition.first_face[region];
  const std::uint32_t face_count = partition.first_face[region + 1] - partition.first_face[region];
  const std::uint32_t corner_count = 3 * face_count;
  LevelTopology& topology = topologies_[0];
  topology.face_count = face_count;
  whole_edge_count = base.edge_count;
  // Numbers in the region by those in the whole, vertices first: all kNone, and left so.
  const std::size_t scratch_size = std::size_t{base.vertex_count} + base.edge_count;
  if ((scratch.size() != scratch_size && !scratch.assign(scratch_size, kNone)) || !edges.reserve(corner_count) ||
      !topology.face_vertices.resize_unset(corner_count) ||
      !topology.face_edges.resize_unset(corner_count)) {
    return no_memory();
  }
  std::uint32_t* const vertex_here = scratch.data();
  std::uint32_t* const edge_here = vertex_here + base.vertex_count;
  for (std::uint32_t corner = 0; corner < corner_count; ++corner) {
    const std::size_t there = std::size_t{3} * faces[corner / 3] + corner % 3;
    const std::uint32_t v = base.face_vertices[there], e = base.face_edges[there];
    if (vertex_here[v] == kNone) vertex_here[v] = topology.vertex_count++;
    if (edge_here[e] == kNone) static_cast<void>(edges.push_back(e));  // room was reserved
    edge_here[e] = 0;
    topology.face_vertices[corner] = vertex_here[v];
  }
  const auto edge_count = static_cast<std::uint32_t>(edges.size());
  sort_numbers(edges.data(), edge_count);
  for (std::uint32_t e = 0; e < edge_count; ++e) edge_here[edges[e]] = e;
  for (std::uint32_t corner = 0; corner < corner_count; ++corner)
    topology.face_edges[corner] = edge_here[base.face_edges[std::size_t{3} * faces[corner / 3] + corner % 3]];
  topology.edge_count = edge_count;
  const bool has_room = topology.edge_vertices.resize_unset(std::size_t{2} * edge_count) &&
                        topology.edge_faces.resize_unset(std::size_t{2} * edge_count) &&
                        (!base.has_curves() ||
                         (topology.edge_is_curve.resize_unset(edge_count) &&
                          topology.vertex_curve_edges.assign(std::size_t{2} * topology.vertex_count, kNone)));
  for (std::uint32_t i = 0; has_room && i < 2 * edge_count; ++i) {
    const std::uint32_t there = 2 * edges[i / 2] + i % 2, face = base.edge_faces[there];
    topology.edge_vertices[i] = vertex_here[base.edge_vertices[there]];
    topology.edge_faces[i] =
        face != kNone && partition.region_of_face[face] == region ? partition.rank_of_face[face] : kNone;
    if (base.has_curves()) topology.edge_is_curve[i / 2] = base.edge_is_curve[edges[i / 2]];
  }
  for (const std::uint32_t e : edges) edge_here[e] = kNone;
  for (std::uint32_t corner = 0; corner < corner_count; ++corner)
    vertex_here[base.face_vertices[std::size_t{3} * faces[corner / 3] + corner % 3]] = kNone;
  return has_room ? number_odd_edges(partition, region, edges) : no_memory();
}

NMC_SELDOM Status RegionLevel::number_odd_edges(const RegionPartition& partition, std::uint32_t region,
                                                const Array<std::uint32_t>& numbers) {
  const LevelTopology& topology = topologies_[current_];
  const std::uint32_t E = topology.edge_count, F = topology.face_count, shift = 2 * topology.level;
  if (!odd_edges.resize_unset(std::size_t{2} * E + std::size_t{3} * F)) return no_memory();
  for (std::uint32_t i = 0; i < 2 * E; ++i)
    odd_edges[i] = topology.edge_faces[i & ~1u] == kNone ? kNone : 2 * numbers[i / 2] + i % 2;
  for (std::uint32_t i = 0; i < 3 * F; ++i) {
    const std::uint32_t f = i / 3, rank = partition.first_face[region] + (f >> shift);
    const std::uint32_t face = (partition.faces[rank] << shift) | (f & ((1u << shift) - 1));
    odd_edges[2 * E + i] = 2 * whole_edge_count + 3 * face + i % 3;
  }
  return ok_status();
}

NMC_SELDOM Status RegionLevel::split(const RegionPartition& partition, std::uint32_t region) {
  const LevelTopology& coarse = topologies_[current_];
  const auto base_face_count = static_cast<std::uint32_t>(partition.faces.size());
  whole_edge_count = 2 * whole_edge_count + 3 * (base_face_count << (2 * coarse.level));
  NMC_TRY(subdivide(coarse, false, topologies_[1 - current_]));
  current_ = 1 - current_;
  edges.swap(odd_edges);
  return number_odd_edges(partition, region, edges);
}

}  // namespace nmc

// SPDX-License-Identifier: Apache-2.0
#include "encoder/pipeline/serialize.h"

#include <algorithm>
#include <cmath>

#include "encoder/core/error.h"
#include "libnmc/encode/stream_writer.h"

namespace nmc {

namespace {

void check(const Status& status) {
  if (!status.ok()) {
    throw Error(ExitCode::kInternal,
                std::string("stream: ") + (status.message() ? status.message() : "out of memory"));
  }
}

std::uint8_t step_code(int eighths) {
  if (eighths < -64 || eighths > 191)
    throw Error(ExitCode::kLimit, "the steps of the levels lie too far apart");
  return static_cast<std::uint8_t>(64 + eighths);
}

LevelCoefficients coefficients_of(const QuantizedMesh& mesh, int level) {
  const auto l = static_cast<std::size_t>(level);
  LevelCoefficients result;
  if (!result.normal.resize(mesh.normal[l].size()) || !result.tangential.resize(mesh.tangential[l].size())) {
    throw Error(ExitCode::kLimit, "out of memory");
  }
  std::copy(mesh.normal[l].begin(), mesh.normal[l].end(), result.normal.begin());
  std::copy(mesh.tangential[l].begin(), mesh.tangential[l].end(), result.tangential.begin());
  return result;
}

}  // namespace

double StreamSteps::grid_step() const {
  Header header;
  header.step_mantissa = mantissa;
  header.step_exponent = exponent;
  return header.grid_step();
}

double StreamSteps::normal_step(int level) const {
  return step_from_code(grid_step(), step_code(eighths_base_to_level_0 + level * eighths_per_level));
}

StreamSteps stream_steps(double finest_normal_step, int level_count, int eighths_per_level,
                         int eighths_base_to_level_0, int eighths_tangential) {
  StreamSteps steps;
  steps.eighths_per_level = eighths_per_level;
  steps.eighths_base_to_level_0 = eighths_base_to_level_0;
  steps.eighths_tangential = eighths_tangential;
  const int eighths = eighths_base_to_level_0 + (level_count - 1) * eighths_per_level;
  const double grid = finest_normal_step * std::exp2(-eighths / 8.0);
  // Ten bits of mantissa: a step within 0.1 % of the one asked for, in two bytes.
  int exponent = 0;
  const double mantissa = std::frexp(grid, &exponent);
  steps.mantissa = static_cast<std::uint32_t>(std::lround(mantissa * 1024));
  steps.exponent = exponent - 10;
  return steps;
}

StreamOrigin stream_origin(const StreamSteps& steps, const Vec3& corner) {
  StreamOrigin origin;
  for (int k = 0; k < 3; ++k) {
    const double at = std::floor(corner[k] / steps.grid_step());
    if (std::abs(at) > static_cast<double>(kMaximumOrigin)) {
      throw Error(ExitCode::kLimit, "the mesh lies too far from its origin for so fine a step: recentre it");
    }
    origin.at[k] = static_cast<std::int64_t>(at);
  }
  return origin;
}

Vec3 StreamOrigin::position(const StreamSteps& steps) const {
  const double step = steps.grid_step();
  return {static_cast<double>(at[0]) * step, static_cast<double>(at[1]) * step,
          static_cast<double>(at[2]) * step};
}

StreamBytes serialize(const std::vector<const QuantizedMesh*>& layers, int layer_ratio,
                      const SubdivisionHierarchy& hierarchy, const std::vector<std::uint8_t>& base_creases,
                      const StreamSteps& steps, const StreamDescription& description,
                      const MeasureLevel& measure, const ColorStream* colors) {
  const QuantizedMesh& mesh = *layers.front();
  const LevelTopology& base = hierarchy.level(0);
  const int coded_level_count = mesh.level_count();
  const int level_count = coded_level_count + mesh.smoothing_level_count;
  const int finest_color_level = colors ? colors->descriptor.finest_level : -1;
  const int stored_level_count = std::max(level_count, finest_color_level);
  if (stored_level_count > kMaximumLevelCount) throw Error(ExitCode::kLimit, "too many levels");

  Header header;
  header.units = description.units;
  header.up_axis = description.up_axis;
  header.has_creases = !base_creases.empty();
  header.step_mantissa = steps.mantissa;
  header.step_exponent = steps.exponent;
  const StreamOrigin origin = stream_origin(steps, description.box.minimum);
  for (int k = 0; k < 3; ++k) {
    header.origin[k] = origin.at[k];
    header.extent[k] = static_cast<std::uint64_t>(
        std::ceil((description.box.maximum[k] - description.box.minimum[k]) / steps.grid_step()));
  }
  header.input_vertex_count = description.input_vertex_count;
  header.input_triangle_count = description.input_triangle_count;
  header.base_vertex_count = base.vertex_count;
  header.base_face_count = base.face_count;
  header.level_count = stored_level_count;
  header.quality_layer_count = static_cast<int>(layers.size());
  if (header.quality_layer_count > kMaximumLayerCount)
    throw Error(ExitCode::kLimit, "too many quality layers");
  for (std::size_t k = 1; k < layers.size(); ++k)
    header.layer_ratio[k] = static_cast<std::uint8_t>(layer_ratio);
  header.tangential_code = step_code(steps.eighths_tangential);
  for (int l = 0; l < level_count; ++l) {
    const bool coded = l < coded_level_count;
    header.step_code[l] =
        coded ? step_code(steps.eighths_base_to_level_0 + l * steps.eighths_per_level) : std::uint8_t{64};
    const double tension = coded ? mesh.quantizers[static_cast<std::size_t>(l)].tension.share : 1.0;
    header.tension_code[l] = static_cast<std::uint8_t>(std::lround(4 * tension));
  }

  // The two finest levels are most of the bytes; what comes before them every region needs.
  const bool has_regions = description.region_count > 0 && coded_level_count > 1;
  const int region_level = has_regions ? std::max(1, coded_level_count - 2) : coded_level_count;
  if (has_regions) {
    // All layers' rows have to fit the table, with those of the levels before.
    const std::uint32_t most = (kMaximumTableSize - 64) / static_cast<std::uint32_t>(layers.size());
    header.region_count = std::min({static_cast<std::uint32_t>(description.region_count), base.face_count,
                                    kMaximumRegionCount, most});
    header.region_level = region_level;
    header.region_level_count = coded_level_count - region_level;
  }

  // On the levels that only colours have, vertices stay where the midpoints are.
  for (int l = level_count; l < stored_level_count; ++l) {
    header.step_code[l] = 64;
    header.tension_code[l] = 0;
  }
  if (colors) {
    header.attribute_count = 1;
    header.attributes[0] = colors->descriptor;
  }

  StreamWriter writer(header);
  StreamBytes result;
  const double diagonal = description.box.diagonal();
  // A row closes when enough bytes have gathered to be worth its entry, and at the end.
  const auto end_row = [&](int level, int region = -1) {
    StreamRow row;
    row.level = level;
    if (measure) {
      check(writer.mesh().update_positions(level));
      const std::size_t count = hierarchy.level(level).vertex_count;
      const Vec3* x = writer.mesh().positions();
      row.error = measure(std::vector<Vec3>(x, x + count), level);
    }
    row.triangle_count = hierarchy.level(level).face_count;
    row.end_offset = writer.chunks().size();
    check(writer.end_layer(level, error_to_code(row.error.rms, diagonal),
                           error_to_code(row.error.maximum, diagonal), region));
    result.rows.push_back(row);
  };

  Array<std::uint32_t> old_index;
  const auto* coordinates = mesh.base_coordinates.front().data();
  check(writer.add_base(base.face_vertices.data(), coordinates,
                        base_creases.empty() ? nullptr : base_creases.data(), old_index));
  for (std::uint32_t v = 0; v < base.vertex_count; ++v) {
    if (old_index[v] != v) throw Error(ExitCode::kInternal, "the base mesh is not in stream order");
  }
  result.base_size = writer.chunks().size();
  // A decoder refuses levels that are large beside the bytes before them, and values beyond a number per byte
  // (spec 8.2). The header is left out here, so the bytes are counted too low. Only surfaces with next to no
  // detail are concerned.
  const auto vertex_count_of = [&](int level) {
    const LevelTopology& known = hierarchy.level(std::min(level, level_count));
    std::uint64_t vertex_count = known.vertex_count, edge_count = known.edge_count,
                  face_count = known.face_count;
    for (int l = level_count; l < level; ++l) {
      vertex_count += edge_count;
      edge_count = 2 * edge_count + 3 * face_count;
      face_count *= 4;
    }
    return vertex_count;
  };
  const auto bytes_needed = [&](int level) {
    const std::uint64_t vertex_count = vertex_count_of(level);
    return vertex_count <= kFreeVertices
               ? 0
               : (vertex_count - kFreeVertices + kVerticesPerByte - 1) / kVerticesPerByte;
  };
  const auto fill_up_to = [&](std::uint64_t needed) {
    if (needed <= writer.chunks().size()) return;
    const std::vector<std::uint8_t> spaces(static_cast<std::size_t>(needed - writer.chunks().size()), ' ');
    check(writer.add_chunk(static_cast<std::uint8_t>(ChunkType::kMetadata), spaces.data(), spaces.size()));
  };
  std::uint64_t value_count = 0;
  const auto count_values = [&](std::uint64_t count) {
    value_count += count;
    if (value_count > kFreeValues)
      fill_up_to((value_count - kFreeValues + kValuesPerByte - 1) / kValuesPerByte);
  };
  int next_color_level = 0;
  /// Colours of all levels up to `level` that have not come yet, in one chunk.
  const auto add_colors = [&](int level) {
    const int last = std::min(level, finest_color_level);
    if (next_color_level > last) return;
    const std::size_t before = writer.chunks().size();
    std::vector<const std::int32_t*> corrections;
    std::uint64_t correction_count = 0;
    for (int l = next_color_level; l <= last; ++l) {
      corrections.push_back(colors->corrections[static_cast<std::size_t>(l)].data());
      correction_count += colors->corrections[static_cast<std::size_t>(l)].size();
    }
    count_values(correction_count);
    check(writer.add_attribute(0, next_color_level, last - next_color_level + 1, corrections.data()));
    next_color_level = last + 1;
    result.color_size += writer.chunks().size() - before;
  };
  add_colors(0);

  std::size_t row_start = 0;
  const auto shown_level = [&](int levels_done) {
    int level = std::min(level_count, levels_done + 2);
    while (level > levels_done && bytes_needed(level) > writer.chunks().size()) --level;
    return level;
  };
  const auto fill_up_for = [&](int level) { fill_up_to(bytes_needed(level)); };
  std::vector<LevelCoefficients> pending;
  const auto flush = [&](int levels_done) {
    if (pending.empty()) return;
    std::vector<const LevelCoefficients*> pointers;
    for (const LevelCoefficients& level : pending) pointers.push_back(&level);
    const int first = levels_done - static_cast<int>(pending.size());
    fill_up_for(levels_done == coded_level_count ? level_count : levels_done);
    for (const LevelCoefficients& level : pending) count_values(level.normal.size());
    check(writer.add_levels(0, first, static_cast<int>(pending.size()), pointers.data()));
    pending.clear();
    add_colors(levels_done);
  };
  const auto nonzero_count = [&](int level) {
    const std::vector<std::int32_t>& normal = mesh.normal[static_cast<std::size_t>(level)];
    return normal.size() - static_cast<std::size_t>(std::count(normal.begin(), normal.end(), 0));
  };
  constexpr std::size_t kSmallestRow = 512;
  if (coded_level_count == 0 || writer.chunks().size() >= kSmallestRow) {
    end_row(coded_level_count == 0 ? level_count : shown_level(0));
    row_start = writer.chunks().size();
  }
  // A chunk and a row of the levels from region_level on for each region.
  const auto add_regions = [&](int number, const QuantizedMesh& layer, const QuantizedMesh* before) {
    if (!has_regions) return;
    std::vector<LevelCoefficients> levels;
    std::vector<const LevelCoefficients*> pointers;
    for (int l = region_level; l < coded_level_count; ++l) levels.push_back(coefficients_of(layer, l));
    for (const LevelCoefficients& level : levels) pointers.push_back(&level);
    check(writer.mesh().ensure_partition());
    const RegionPartition& partition = writer.mesh().partition();
    const auto region_of = [&](std::uint32_t face) { return face == kNone ? -1 : static_cast<int>(partition.region_of_face[face]); };
    std::vector<std::uint64_t> border_counts(header.region_count, 0);
    for (std::uint32_t e = 0; e < base.edge_count; ++e) {
      const int left = region_of(base.edge_faces[2 * e]), right = region_of(base.edge_faces[2 * e + 1]);
      if (left == right) continue;
      for (const int side : {left, right})
        if (side >= 0) ++border_counts[static_cast<std::size_t>(side)];
    }
    for (int region = 0; region < static_cast<int>(header.region_count); ++region) {
      fill_up_for(level_count);
      const std::uint64_t border_count = border_counts[static_cast<std::size_t>(region)];
      for (int l = region_level; l < coded_level_count; ++l) {
        // Edges of the region's level, and entries of the whole's list, which may join those of both layers.
        const std::uint64_t face_count = partition.first_face[region + 1] - partition.first_face[region];
        const auto level = static_cast<std::size_t>(l);
        count_values((6 * face_count << (2 * (l - 1))) + (border_count << (l - 1)) + layer.tangential[level].size() +
                     (before ? before->tangential[level].size() : 0));
      }
      check(writer.add_region(number, region, pointers.data()));
      end_row(level_count, region);
    }
  };
  for (int l = 0; l < region_level; ++l) {
    const std::size_t before = writer.chunks().size();
    pending.push_back(coefficients_of(mesh, l));
    const bool last = l + 1 == region_level;
    // Levels grow: a level of few coefficients shares its chunk and row with the next one, and so do the last
    // levels when what follows would not fill a row of its own.
    std::size_t rest = 0;
    for (int m = l + 1; m < region_level; ++m) rest += nonzero_count(m);
    const bool is_small = nonzero_count(l) + (before - row_start) < kSmallestRow;
    if (!last && (is_small || rest < kSmallestRow / 2)) continue;
    flush(l + 1);
    result.level_sizes.push_back(writer.chunks().size() - before);
    end_row(last && !has_regions ? level_count : shown_level(l + 1));
    row_start = writer.chunks().size();
  }
  add_regions(0, mesh, nullptr);

  // Later quality layers refine all levels; their rows show the finest level, half of each layer's levels at
  // a time.
  for (std::size_t k = 1; k < layers.size(); ++k) {
    const QuantizedMesh& layer = *layers[k];
    const int number = static_cast<int>(k);
    check(writer.add_base_correction(number, layer.base_coordinates.front().data()));
    for (int first = 0; first < region_level;) {
      const int last = first == 0 && !has_regions && coded_level_count > 1 ? coded_level_count - 1 : region_level;
      std::vector<LevelCoefficients> levels;
      for (int l = first; l < last; ++l) levels.push_back(coefficients_of(layer, l));
      std::vector<const LevelCoefficients*> pointers;
      for (const LevelCoefficients& level : levels) pointers.push_back(&level);
      for (const LevelCoefficients& level : levels) count_values(level.normal.size());
      check(writer.add_levels(number, first, last - first, pointers.data()));
      first = last;
      end_row(level_count);
    }
    add_regions(number, layer, layers[k - 1]);
  }

  for (int l = level_count + 1; l <= stored_level_count; ++l) {
    fill_up_for(l);
    add_colors(l);
    StreamRow row = result.rows.back();
    row.level = l;
    row.triangle_count *= 4;
    row.end_offset = writer.chunks().size();
    check(writer.end_layer(l, error_to_code(row.error.rms, diagonal),
                           error_to_code(row.error.maximum, diagonal)));
    result.rows.push_back(row);
  }

  Array<std::uint8_t> bytes;
  check(writer.write_stream(bytes));
  result.header_size = bytes.size() - writer.chunks().size();
  for (StreamRow& row : result.rows) row.end_offset += result.header_size;
  result.bytes.assign(bytes.begin(), bytes.end());
  result.region_count = static_cast<int>(header.region_count);
  result.state_hash = writer.mesh().state_hash();
  if (measure) {
    check(writer.mesh().update_positions(stored_level_count));
    result.position_hash = writer.mesh().position_hash(stored_level_count);
  }
  return result;
}

}  // namespace nmc

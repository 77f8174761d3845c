// SPDX-License-Identifier: Apache-2.0
// Random valid streams, with what a decoder must find in them: they reach corners of the format that no
// encoder of real surfaces visits.
#ifndef NMC_TESTS_SUPPORT_STREAM_GENERATOR_H_
#define NMC_TESTS_SUPPORT_STREAM_GENERATOR_H_

#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "libnmc/encode/stream_writer.h"
#include "tests/support/random_base_mesh.h"

namespace nmc::test {

/// The state after one row of the layer table.
struct ExpectedLayer {
  std::uint64_t end_offset = 0;
  int level = 0;
  std::uint64_t state_hash = 0;
  std::uint64_t position_hash = 0;                   // at `level`
  std::vector<std::uint64_t> attribute_hashes = {};  // at `level`; 0 for attributes that have not come
};

struct GeneratedStream {
  std::string name;
  std::vector<std::uint8_t> bytes;
  std::vector<ExpectedLayer> layers;
};

inline void require(const Status& status) {
  if (!status.ok())
    throw std::runtime_error(status.message() ? status.message() : "the stream could not be written");
}

/// What a stream is to hold. The defaults are the smallest stream there is.
struct StreamRecipe {
  std::string name = "stream";
  SmallMesh base = tetrahedron();
  int level_count = 0;
  int quality_layer_count = 1;
  bool has_creases = false;
  std::int64_t largest_coordinate = 100;
  /// Share of odd vertices with a coefficient that is not zero, and how large it may be.
  double density = 0.3;
  std::int64_t largest_coefficient = 6;
  double tangential_density = 0;
  bool has_ancillary_chunks = false;
  bool one_layer_per_chunk = true;
  bool has_tensions = false;
  /// Attributes of random shape; the first is a colour of eight bits.
  int attribute_count = 0;
  /// Regions (spec 5.4) in streams of two levels and more; some of them have no chunks.
  int region_count = 0;
  bool regions_share_rows = true;  // some of them
  std::uint64_t seed = 1;
};

/// Writes streams by recipe; every number in them comes from the recipe's seed.
class StreamGenerator {
 public:
  explicit StreamGenerator(const StreamRecipe& recipe) : recipe_(recipe), random_(recipe.seed) {}

  GeneratedStream generate() {
    fill_header();
    writer_ = std::make_unique<StreamWriter>(header_);
    write_base();
    for (int layer = 0; layer < header_.quality_layer_count; ++layer) {
      if (layer > 0) write_base_correction(layer);
      const int shared_count = header_.region_count > 0 ? header_.region_level : header_.level_count;
      for (int level = 0; level < shared_count;) {
        int count =
            recipe_.one_layer_per_chunk ? 1 : static_cast<int>(random_.between(1, shared_count - level));
        write_levels(layer, level, count);
        level += count;
        write_attributes(level);
        if (recipe_.one_layer_per_chunk || level == shared_count || random_.chance(0.5)) {
          end_layer(layer == 0 ? level : header_.level_count);
        }
      }
      if (header_.region_count > 0) write_regions(layer);
      if (header_.level_count == 0 && layer > 0) end_layer(0);
    }
    Array<std::uint8_t> bytes;
    require(writer_->write_stream(bytes));
    result_.name = recipe_.name;
    result_.bytes.assign(bytes.begin(), bytes.end());
    const std::uint64_t header_size = bytes.size() - writer_->chunks().size();
    for (ExpectedLayer& layer : result_.layers) layer.end_offset += header_size;
    return std::move(result_);
  }

 private:
  void fill_header() {
    header_.units = static_cast<Units>(random_.below(7));
    header_.up_axis = static_cast<UpAxis>(random_.below(3));
    header_.step_mantissa = static_cast<std::uint32_t>(random_.between(1, (1 << 24) - 1));
    header_.step_exponent = static_cast<int>(random_.between(-40, 10));
    for (std::int64_t& o : header_.origin) o = random_.between(-1000000, 1000000);
    for (std::uint64_t& e : header_.extent) e = static_cast<std::uint64_t>(random_.between(1, 1000000));
    header_.input_vertex_count = random_.below(1000000);
    header_.input_triangle_count = random_.below(1000000);
    header_.base_vertex_count = recipe_.base.vertex_count;
    header_.base_face_count = static_cast<std::uint32_t>(recipe_.base.faces.size());
    header_.level_count = recipe_.level_count;
    header_.quality_layer_count = recipe_.quality_layer_count;
    for (int k = 1; k < header_.quality_layer_count; ++k) {
      header_.layer_ratio[k] = static_cast<std::uint8_t>(random_.between(1, 3));
    }
    if (recipe_.region_count > 0 && recipe_.level_count > 1) {
      header_.region_count = static_cast<std::uint32_t>(recipe_.region_count);
      header_.region_level = static_cast<int>(random_.between(1, header_.level_count - 1));
      header_.region_level_count = static_cast<int>(random_.between(1, header_.level_count - header_.region_level));
    }
    for (int l = 0; l < header_.level_count; ++l) {
      header_.step_code[l] = static_cast<std::uint8_t>(random_.between(20, 90));
      header_.tension_code[l] = recipe_.has_tensions ? static_cast<std::uint8_t>(random_.between(0, 8)) : 4;
    }
    header_.tangential_code = header_.level_count > 0 ? 80 : 0;
    header_.has_creases = recipe_.has_creases;
    header_.attribute_count = recipe_.attribute_count;
    for (int i = 0; i < recipe_.attribute_count; ++i) fill_attribute(i, header_.attributes[i]);
  }

  void fill_attribute(int index, AttributeDescriptor& attribute) {
    if (index > 0) {
      attribute.kind = static_cast<std::uint8_t>(random_.between(64, 255));
      attribute.component_count = static_cast<int>(random_.between(1, 4));
      attribute.bit_count = static_cast<int>(random_.between(1, 14));
    }
    attribute.is_decorrelated = attribute.component_count >= 3 && (index == 0 || random_.chance(0.5));
    attribute.finest_level =
        index == 0 ? header_.level_count : static_cast<int>(random_.below(header_.level_count + 1));
    for (int l = 0; l <= attribute.finest_level; ++l) {
      for (std::uint8_t& step : attribute.levels[l].step)
        step = static_cast<std::uint8_t>(random_.chance(0.2) ? 255 : random_.between(1, 12));
      attribute.levels[l].opposite_share = static_cast<int>(random_.between(-4, 11));
      attribute.levels[l].near_share = static_cast<int>(random_.between(0, 15));
    }
  }

  /// Values of all attributes for the levels up to `level` that have not come yet.
  void write_attributes(int level) {
    for (int i = 0; i < header_.attribute_count; ++i) {
      const AttributeDescriptor& attribute = header_.attributes[i];
      const int first = writer_->mesh().attribute(i).next_level();
      const int last = level < attribute.finest_level ? level : attribute.finest_level;
      std::vector<std::vector<std::int32_t>> corrections;
      std::vector<const std::int32_t*> pointers;
      for (int l = first; l <= last; ++l) {
        if (l > 0) require(writer_->mesh().ensure_topology(l - 1, false));
        const std::size_t count =
            l == 0 ? recipe_.base.vertex_count : writer_->mesh().topology(l - 1).edge_count;
        corrections.emplace_back(count * static_cast<std::size_t>(attribute.component_count));
        for (std::int32_t& q : corrections.back()) {
          if (!random_.chance(recipe_.density)) continue;
          const std::int32_t largest =
              random_.chance(0.02) ? kMaximumCorrection : attribute.largest_value() / 16 + 1;
          q = static_cast<std::int32_t>(random_.between(-largest, largest));
        }
      }
      for (const std::vector<std::int32_t>& of_level : corrections) pointers.push_back(of_level.data());
      if (!pointers.empty())
        require(writer_->add_attribute(i, first, static_cast<int>(pointers.size()), pointers.data()));
    }
  }

  std::int32_t coordinate() {
    return static_cast<std::int32_t>(
        random_.between(-recipe_.largest_coordinate, recipe_.largest_coordinate));
  }

  void write_base() {
    std::vector<std::int32_t> coordinates(3 * recipe_.base.vertex_count);
    for (std::int32_t& x : coordinates) x = coordinate();
    std::vector<std::uint8_t> creases;
    if (header_.has_creases) {
      // Which edges there are is known in the stream's numbering only; inner edges become creases by chance.
      Array<std::uint32_t> order, faces;
      require(order_base_mesh(recipe_.base.faces[0].data(), header_.base_face_count,
                              header_.base_vertex_count, nullptr, order, faces));
      LevelTopology topology;
      require(build_base_topology(faces.data(), header_.base_face_count, header_.base_vertex_count, nullptr,
                                  topology));
      creases.resize(topology.edge_count);
      for (std::uint32_t e = 0; e < topology.edge_count; ++e) {
        creases[e] = !topology.is_boundary(e) && random_.chance(0.3);
      }
    }
    Array<std::uint32_t> old_index;
    require(writer_->add_base(recipe_.base.faces[0].data(), coordinates.data(),
                              creases.empty() ? nullptr : creases.data(), old_index));
    if (recipe_.has_ancillary_chunks) write_ancillary_chunk();
    write_attributes(0);
    if (recipe_.one_layer_per_chunk || header_.level_count == 0 || random_.chance(0.5)) end_layer(0);
  }

  void write_base_correction(int layer) {
    std::vector<std::int32_t> coordinates(3 * recipe_.base.vertex_count);
    const BaseMesh& base = writer_->mesh().base();
    for (std::size_t i = 0; i < coordinates.size(); ++i) {
      coordinates[i] = static_cast<std::int32_t>(
          base.coordinates[i] * std::int64_t{header_.layer_ratio[layer]} + random_.between(-2, 2));
    }
    require(writer_->add_base_correction(layer, coordinates.data()));
  }

  std::int32_t coefficient() {
    const std::int64_t largest = recipe_.largest_coefficient;
    if (random_.chance(0.02)) return static_cast<std::int32_t>(random_.chance(0.5) ? largest : -largest);
    // Small magnitudes are common, as in real surfaces.
    std::int64_t bound = 1;
    while (bound < largest && random_.chance(0.6)) bound *= 2;
    bound = bound < largest ? bound : largest;
    return static_cast<std::int32_t>(random_.between(-bound, bound));
  }

  /// New values for a level: in the first layer by chance, later what the earlier layer says, refined. `ratio`: of
  /// the steps of what the mesh holds to those of the layer.
  LevelCoefficients new_coefficients(int layer, int level, std::int64_t ratio) {
    const LevelTopology& topology = writer_->mesh().topology(level);
    const LevelCoefficients& old = writer_->mesh().coefficients(level);
    LevelCoefficients values;
    const auto clamped = [&](std::int64_t x) {
      const std::int64_t largest = kMaximumMagnitude;
      return static_cast<std::int32_t>(x > largest ? largest : x < -largest ? -largest : x);
    };
    if (!values.normal.resize(topology.edge_count)) throw std::bad_alloc();
    for (std::uint32_t e = 0; e < topology.edge_count; ++e) {
      const bool changes = random_.chance(recipe_.density);
      const std::int64_t start = layer > 0 ? std::int64_t{old.normal[e]} * ratio : 0;
      values.normal[e] =
          clamped(changes ? (layer > 0 && random_.chance(0.1) ? 0 : start) + coefficient() : start);
    }
    std::size_t position = 0;
    for (std::uint32_t e = 0; e < topology.edge_count; ++e) {
      TangentialCoefficient t{e, 0, 0};
      if (layer > 0 && position < old.tangential.size() && old.tangential[position].edge == e) {
        t.along = clamped(old.tangential[position].along * ratio);
        t.across = clamped(old.tangential[position].across * ratio);
        ++position;
      }
      if (random_.chance(recipe_.tangential_density)) t.along = coefficient();
      if (random_.chance(topology.is_curve(e) ? 0.7 : recipe_.tangential_density)) t.across = coefficient();
      if ((t.along != 0 || t.across != 0) && !values.tangential.push_back(t)) throw std::bad_alloc();
    }
    return values;
  }

  void write_levels(int layer, int first_level, int count) {
    std::vector<LevelCoefficients> values;
    std::vector<const LevelCoefficients*> pointers;
    for (int i = 0; i < count; ++i) {
      require(writer_->mesh().ensure_topology(first_level + i, false));
      values.push_back(new_coefficients(layer, first_level + i, header_.layer_ratio[layer]));
    }
    for (const LevelCoefficients& v : values) pointers.push_back(&v);
    require(writer_->add_levels(layer, first_level, count, pointers.data()));
    if (recipe_.has_ancillary_chunks && random_.chance(0.5)) write_ancillary_chunk();
  }

  /// Region 0 in any case, others by chance, in an order drawn by chance; most of them in rows of their own.
  void write_regions(int layer) {
    std::vector<int> order;
    for (int region = 0; region < static_cast<int>(header_.region_count); ++region) {
      if (static_cast<int>(missing_.size()) <= region) missing_.push_back(region > 0 && random_.chance(0.2));
      if (!missing_[static_cast<std::size_t>(region)]) order.push_back(region);
    }
    for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random_.below(i)]);
    for (std::size_t i = 0; i < order.size(); ++i) {
      std::vector<LevelCoefficients> values;
      std::vector<const LevelCoefficients*> pointers;
      for (int l = header_.region_level; l < header_.region_level + header_.region_level_count; ++l) {
        require(writer_->mesh().ensure_topology(l, false));
        // What another region of this layer has brought to its steps is not scaled again.
        const bool is_scaled = writer_->mesh().layer_of_level(l) == layer;
        values.push_back(new_coefficients(layer, l, is_scaled ? 1 : header_.layer_ratio[layer]));
      }
      for (const LevelCoefficients& v : values) pointers.push_back(&v);
      require(writer_->add_region(layer, order[i], pointers.data()));
      if (i + 1 == order.size()) write_attributes(header_.level_count);
      const bool has_attributes = i + 1 == order.size() && header_.attribute_count > 0;
      if (random_.chance(0.8) || !recipe_.regions_share_rows || i + 1 == order.size())
        end_layer(header_.level_count, shares_row_ || has_attributes ? -1 : order[i]);
      else
        shares_row_ = true;
    }
  }

  void write_ancillary_chunk() {
    std::vector<std::uint8_t> payload(random_.below(40));
    for (std::uint8_t& byte : payload) byte = static_cast<std::uint8_t>(random_.below(256));
    const auto type = static_cast<std::uint8_t>(random_.between(0xc0, 0xff));
    require(writer_->add_chunk(type, payload.data(), payload.size()));
  }

  void end_layer(int level, int region = -1) {
    shares_row_ = false;
    const auto error = static_cast<std::uint16_t>(1000 + 50 * result_.layers.size());
    require(writer_->end_layer(level, static_cast<std::uint16_t>(error + 500), error, region));
    ExpectedLayer expected;
    expected.end_offset = writer_->chunks().size();
    expected.level = level;
    require(writer_->mesh().update_positions(level));
    expected.state_hash = writer_->mesh().state_hash();
    expected.position_hash = writer_->mesh().position_hash(level);
    for (int i = 0; i < header_.attribute_count; ++i) {
      const bool is_there = writer_->mesh().update_attribute(i, level).ok();
      const auto vertex_count = static_cast<std::uint32_t>(vertex_count_of(level));
      expected.attribute_hashes.push_back(
          is_there ? writer_->mesh().attribute(i).hash(header_.attributes[i], vertex_count) : 0);
    }
    result_.layers.push_back(expected);
  }

  std::size_t vertex_count_of(int level) const {
    const LevelTopology& coarse = writer_->mesh().topology(level > 0 ? level - 1 : 0);
    return std::size_t{coarse.vertex_count} + (level > 0 ? coarse.edge_count : 0);
  }

  StreamRecipe recipe_;
  RandomIntegers random_;
  Header header_;
  std::unique_ptr<StreamWriter> writer_;
  GeneratedStream result_;
  std::vector<bool> missing_;  // per region
  bool shares_row_ = false;    // a region's chunk lies in the row that is not ended yet
};

inline GeneratedStream generate(const StreamRecipe& recipe) { return StreamGenerator(recipe).generate(); }

/// A recipe drawn by chance: every feature of the format turns up within a few dozen seeds.
inline StreamRecipe random_recipe(std::uint64_t seed) {
  RandomIntegers random(seed);
  StreamRecipe recipe;
  recipe.seed = seed;
  recipe.name = "random " + std::to_string(seed);
  recipe.base = random_base_mesh(random, static_cast<int>(random.between(0, 40)));
  recipe.level_count = static_cast<int>(random.between(0, 3));
  recipe.quality_layer_count = random.chance(0.5) ? 1 : static_cast<int>(random.between(2, 4));
  recipe.has_creases = random.chance(0.4);
  recipe.largest_coordinate = random.chance(0.2) ? kMaximumBaseCoordinate / 81 - 10 : random.between(1, 5000);
  recipe.density = random.chance(0.3) ? 0.02 : random.chance(0.3) ? 1.0 : 0.3;
  recipe.largest_coefficient = random.chance(0.2) ? kMaximumMagnitude : random.between(1, 300);
  recipe.tangential_density = random.chance(0.5) ? 0 : 0.1;
  recipe.has_ancillary_chunks = random.chance(0.3);
  recipe.one_layer_per_chunk = random.chance(0.6);
  recipe.has_tensions = random.chance(0.3);
  if (random.chance(0.4)) {
    const auto face_count = static_cast<std::int64_t>(recipe.base.faces.size());
    recipe.region_count = static_cast<int>(random.between(1, face_count < 6 ? face_count : 6));
  }
  return recipe;
}

}  // namespace nmc::test

#endif  // NMC_TESTS_SUPPORT_STREAM_GENERATOR_H_

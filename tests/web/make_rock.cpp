// SPDX-License-Identifier: Apache-2.0
// Writes a large stream in seconds: a rock, an octahedron whose odd vertices are set off by random lengths
// that halve from level to level (A. Fournier, D. Fussell, L. Carpenter, Computer Rendering of Stochastic
// Models, CACM 25(6), 1982: midpoint displacement). Encoding a scan to the same size would take minutes. The
// stated errors are distances between corresponding vertices of each row and the last one, so they hold, and
// are a little large. Usage: make-rock OUTPUT [LEVELS] [BITS]: BITS is about how many each coefficient takes.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "libnmc/encode/stream_writer.h"

namespace {

using nmc::Array;
using nmc::Status;

constexpr int kQualityLayers = 3;
constexpr int kLayerRatio = 16;       // the largest there is: a later layer adds four bits
constexpr int kBaseRadius = 1 << 24;  // in steps of the grid
constexpr double kRoughness = 0.24, kDecay = 0.52;

void check(const Status& status) {
  if (status.ok()) return;
  std::fprintf(stderr, "make-rock: %s\n", status.message() ? status.message() : "failed");
  std::exit(1);
}

/// Steele, Lea and Flood's SplitMix64: the same numbers everywhere.
std::uint64_t random_bits(std::uint64_t& state) {
  std::uint64_t z = (state += 0x9e3779b97f4a7c15u);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}
/// In [-1, 1], near 0 more often.
double random_length(std::uint64_t& state) {
  const std::uint64_t bits = random_bits(state);
  const double a = static_cast<double>(bits & 0xffffffffu), b = static_cast<double>(bits >> 32);
  return (a + b) / 4294967295.0 - 1;
}

struct RowError {
  double rms = 0, maximum = 0;
};

class Rock {
 public:
  Rock(int levels, int bits) : levels_(levels), bits_(bits) {}

  /// The stream; the rows' errors are against `finest`, and unknown when it is empty.
  std::vector<std::uint8_t> write(std::vector<nmc::Vec3>& finest) {
    nmc::Header header;
    header.units = nmc::Units::kMetre;
    header.up_axis = nmc::UpAxis::kY;
    header.step_mantissa = 1;
    header.step_exponent = -24;
    for (int k = 0; k < 3; ++k) {
      header.origin[k] = -5 * kBaseRadius / 4;
      header.extent[k] = 5 * kBaseRadius / 2;
    }
    header.base_vertex_count = 6;
    header.base_face_count = 8;
    header.level_count = levels_;
    header.input_vertex_count = (std::uint64_t{4} << (2 * levels_)) + 2;
    header.input_triangle_count = std::uint64_t{8} << (2 * levels_);
    header.quality_layer_count = kQualityLayers;
    for (int q = 1; q < kQualityLayers; ++q) header.layer_ratio[q] = kLayerRatio;
    const double grid_step = header.grid_step();
    for (int l = 0; l < levels_; ++l) {
      // The finest level's amplitude is `bits` bits of its step; coarser levels have as many.
      const double step = amplitude(l) / std::exp2(bits_);
      const int code = 64 + static_cast<int>(std::floor(8 * std::log2(step / grid_step)));
      header.step_code[l] = static_cast<std::uint8_t>(std::clamp(code, 0, 255));
      header.tension_code[l] = 4;
    }

    nmc::StreamWriter writer(header);
    write_base(writer);
    std::vector<RowError> errors;
    const auto end_row = [&](int level) {
      check(writer.end_layer(level, nmc::kUnknownError, nmc::kUnknownError));
      if (!finest.empty()) errors.push_back(measure(writer, finest));
    };
    end_row(0);
    for (int q = 0; q < kQualityLayers; ++q) {
      if (q > 0) {
        std::vector<std::int32_t> base(writer.mesh().base().coordinates.begin(),
                                       writer.mesh().base().coordinates.end());
        for (std::int32_t& x : base) x *= header.layer_ratio[q];
        check(writer.add_base_correction(q, base.data()));
      }
      for (int l = 0; l < levels_; ++l) {
        write_level(writer, header, q, l);
        // Later layers close rows for the large levels only.
        if (q == 0 || l + 3 > levels_) end_row(q == 0 ? l + 1 : levels_);
      }
    }
    if (finest.empty()) {
      check(writer.mesh().update_positions(levels_));
      const std::size_t count =
          writer.mesh().topology(levels_ - 1).vertex_count + writer.mesh().topology(levels_ - 1).edge_count;
      finest.assign(writer.mesh().positions(), writer.mesh().positions() + count);
    }
    for (std::size_t i = 0; i < errors.size(); ++i) {
      header.layers[i].rms_error = nmc::error_to_code(errors[i].rms, header.diagonal());
      header.layers[i].max_error = nmc::error_to_code(errors[i].maximum, header.diagonal());
    }
    Array<std::uint8_t> bytes;
    check(writer.write_stream(bytes));
    return {bytes.begin(), bytes.end()};
  }

 private:
  static double amplitude(int level) { return kRoughness * std::pow(kDecay, level); }

  void write_base(nmc::StreamWriter& writer) {
    constexpr std::uint32_t faces[8][3] = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                                           {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
    std::int32_t coordinates[18];
    // They count from the corner of the box, whose centre is the origin.
    std::fill(coordinates, coordinates + 18, 5 * kBaseRadius / 4);
    for (int v = 0; v < 6; ++v) coordinates[3 * v + v / 2] += v % 2 == 0 ? kBaseRadius : -kBaseRadius;
    // The first quality layer's grid is coarser by the product of the ratios.
    for (std::int32_t& x : coordinates) x /= kLayerRatio * kLayerRatio;
    Array<std::uint32_t> old_index;
    check(writer.add_base(faces[0], coordinates, nullptr, old_index));
  }
  void write_level(nmc::StreamWriter& writer, const nmc::Header& header, int layer, int level) {
    check(writer.mesh().ensure_topology(level, false));
    const nmc::LevelTopology& topology = writer.mesh().topology(level);
    const double step = header.quantizer(level, layer).normal_step;
    nmc::LevelCoefficients values;
    if (!values.normal.resize(topology.edge_count)) std::exit(1);
    std::uint64_t state = 0x6e6d63u + static_cast<std::uint64_t>(level);
    for (std::uint32_t e = 0; e < topology.edge_count; ++e) {
      values.normal[e] =
          static_cast<std::int32_t>(std::lround(amplitude(level) * random_length(state) / step));
    }
    const nmc::LevelCoefficients* pointer = &values;
    check(writer.add_levels(layer, level, 1, &pointer));
  }

  RowError measure(nmc::StreamWriter& writer, const std::vector<nmc::Vec3>& finest) {
    check(writer.mesh().ensure_topology(levels_, true));
    check(writer.mesh().update_positions(levels_));
    const nmc::Vec3* positions = writer.mesh().positions();
    RowError error;
    double sum = 0;
    for (std::size_t v = 0; v < finest.size(); ++v) {
      double squared = 0;
      for (int k = 0; k < 3; ++k) {
        squared += (positions[v][k] - finest[v][k]) * (positions[v][k] - finest[v][k]);
      }
      sum += squared;
      error.maximum = std::max(error.maximum, squared);
    }
    error.maximum = std::sqrt(error.maximum);
    error.rms = std::sqrt(sum / static_cast<double>(finest.size()));
    return error;
  }

  int levels_, bits_;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: make-rock OUTPUT [LEVELS] [BITS]\n");
    return 1;
  }
  Rock rock(argc > 2 ? std::atoi(argv[2]) : 9, argc > 3 ? std::atoi(argv[3]) : 23);
  std::vector<nmc::Vec3> finest;
  rock.write(finest);
  const std::vector<std::uint8_t> bytes = rock.write(finest);
  std::FILE* file = std::fopen(argv[1], "wb");
  if (!file || std::fwrite(bytes.data(), 1, bytes.size(), file) != bytes.size() || std::fclose(file) != 0) {
    std::fprintf(stderr, "make-rock: %s cannot be written\n", argv[1]);
    return 2;
  }
  return 0;
}

// SPDX-License-Identifier: Apache-2.0
// The reference decoder. Read it beside format-spec.md: the order is the same and every part names its
// section. Clarity comes before speed: neighbours are looked up where they are needed, and every row of the
// layer table computes its positions from the base mesh on.
#include "decoder/reference/reference_decoder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <map>
#include <memory>
#include <utility>

#include "decoder/reference/trained_tables.h"

namespace nmc_reference {

namespace {

using i32 = std::int32_t;
using i64 = std::int64_t;
using u8 = std::uint8_t;
using u32 = std::uint32_t;
using u64 = std::uint64_t;

constexpr u32 kNone = 0xffffffffu;

// ---- 1.3 Errors ----

struct Failure {
  Code code;
  const char* section;
};
[[noreturn]] void fail(Code code, const char* section) { throw Failure{code, section}; }
void check(bool rule, const char* section) {
  if (!rule) fail(Code::kCorrupt, section);
}

i64 clamp(i64 x, i64 low, i64 high) { return std::max(low, std::min(high, x)); }
i32 sign_of(i64 x) { return x > 0 ? 1 : x < 0 ? -1 : 0; }
int bit_length(u64 x) {
  int n = 0;
  for (; x; x >>= 1) ++n;
  return n;
}

// ---- 2 Notation ----

/// Reads the fields of a header or the frame of a chunk. Beyond the end everything reads as zero (3.3).
struct Reader {
  const u8* data;
  std::size_t size;
  std::size_t position = 0;
  bool is_past_end = false;
  bool is_misspelt = false;

  u64 fixed(int byte_count) {
    u64 value = 0;
    for (int i = 0; i < byte_count; ++i) {
      if (position >= size) is_past_end = true;
      value |= static_cast<u64>(position < size ? data[position++] : 0) << (8 * i);
    }
    return value;
  }
  u64 varint() {  // 2.2
    u64 value = 0;
    for (int i = 0; i < 10; ++i) {
      const u64 byte = fixed(1);
      if ((i > 0 && byte == 0) || (i == 9 && byte > 1)) is_misspelt = true;
      value |= (byte & 127) << (7 * i);
      if (byte < 128) return value;
    }
    is_misspelt = true;
    return 0;
  }
  i64 svarint() {
    const u64 u = varint();
    return u & 1 ? static_cast<i64>(~(u >> 1)) : static_cast<i64>(u >> 1);
  }
};

// ---- 3.3 Header ----

struct LayerTableRow {
  u64 size;
  u32 level, region;
};
/// Section 10.1.
struct AttributeTable {
  u32 components = 0;
  int bits = 0, finest_level = 0;
  bool has_chroma = false;
  struct {
    i64 step[4] = {};
    i64 opposite_share = 0, near_share = 0;
  } level[15];

  i64 held(i64 value, u32 c) const {
    const i64 largest = (1 << bits) - 1;
    return clamp(value, has_chroma && (c == 1 || c == 2) ? -largest : 0, largest);
  }
};
struct Header {
  std::vector<AttributeTable> attributes;
  bool has_creases = false;
  double grid_step = 0;
  i64 origin[3] = {};
  u32 vertex_count = 0, face_count = 0;
  int level_count = 0, layer_count = 1;
  i64 layer_ratio[16] = {};
  u32 region_count = 0;
  int region_level = 0, region_level_count = 0;
  int tangential_code = 0, step_code[14] = {}, tension_code[14] = {};
  std::vector<LayerTableRow> rows;

  i64 ratio_after(int layer) const {
    i64 ratio = 1;
    for (int k = layer + 1; k < layer_count; ++k) ratio *= layer_ratio[k];
    return ratio;
  }
};

constexpr double kEighthRoots[8] = {  // B.3
    1.0,
    1.0905077326652577,
    1.189207115002721,
    1.2968395546510096,
    1.4142135623730951,
    1.5422108254079407,
    1.681792830507429,
    1.8340080864093424};

AttributeTable read_attribute(Reader& reader, int level_count) {
  AttributeTable table;
  const u64 kind = reader.fixed(1);
  check(kind != 0, "10.1");
  table.components = static_cast<u32>(reader.fixed(1));
  check(table.components >= 1 && table.components <= 4, "10.1");
  table.bits = static_cast<int>(reader.fixed(1));
  check(table.bits >= 1 && table.bits <= 14, "10.1");
  const u64 flags = reader.fixed(1);
  check(flags < 2, "10.1");
  table.has_chroma = flags == 1;
  check((kind != 1 && flags == 0) || table.components >= 3, "10.1");
  table.finest_level = static_cast<int>(reader.fixed(1));
  check(table.finest_level <= level_count, "10.1");
  for (int l = 0; l <= table.finest_level; ++l) {
    for (u32 c = 0; c < table.components; ++c)
      check((table.level[l].step[c] = static_cast<i64>(reader.fixed(1))) > 0, "10.1");
    if (l == 0) continue;
    const u64 shares = reader.fixed(1);
    table.level[l].opposite_share = static_cast<i64>(shares & 15) - 4;
    table.level[l].near_share = static_cast<i64>(shares >> 4);
  }
  return table;
}

Header read_header(const u8* fields, std::size_t size) {
  Reader reader{fields, size};
  Header h;
  const u64 flags = reader.fixed(1);  // 3.3.1
  check(flags < 32, "3.3.1");
  h.has_creases = flags & 1;
  const u64 frame = reader.fixed(1);  // 3.3.2
  check((frame & 15) <= 6 && (frame >> 4) <= 2, "3.3.2");

  const u64 mantissa = reader.varint();  // 3.3.3
  const i64 exponent = reader.svarint();
  check(mantissa >= 1 && mantissa < (1u << 24) && exponent >= -160 && exponent <= 100, "3.3.3");
  h.grid_step = std::ldexp(static_cast<double>(mantissa), static_cast<int>(exponent));
  constexpr i64 kFarthest = i64{1} << 51;
  for (i64& o : h.origin) check((o = reader.svarint()) >= -kFarthest && o <= kFarthest, "3.3.3");
  for (int i = 0; i < 3; ++i) check(reader.varint() <= kFarthest, "3.3.3");

  reader.varint();  // 3.3.4: input_vertex_count, input_triangle_count
  reader.varint();
  const u64 v = reader.varint(), f = reader.varint(), most = (u64{1} << 30) - 2;
  check(v >= 3 && v <= most && f >= 1 && f <= most && v <= 3 * f && f <= 2 * v + (1u << 29) - 1, "3.3.4");
  h.vertex_count = static_cast<u32>(v);
  h.face_count = static_cast<u32>(f);
  check((h.level_count = static_cast<int>(reader.fixed(1))) <= 14, "3.3.4");
  if (flags & 8) {
    h.layer_count = static_cast<int>(reader.fixed(1));
    check(h.layer_count >= 2 && h.layer_count <= 16, "3.3.4");
    for (int k = 1; k < h.layer_count; ++k) {
      h.layer_ratio[k] = static_cast<i64>(reader.fixed(1));
      check(h.layer_ratio[k] >= 1 && h.layer_ratio[k] <= 16, "3.3.4");
      i64 product = 1;
      for (int j = 1; j <= k; ++j) product *= h.layer_ratio[j];
      check(product <= (1 << 20), "3.3.4");
    }
  }
  if (flags & 16) {
    h.region_count = static_cast<u32>(reader.fixed(1));
    check(h.region_count >= 1 && h.region_count <= 64 && h.region_count <= f, "3.3.4");
    h.region_level = static_cast<int>(reader.fixed(1));
    h.region_level_count = static_cast<int>(reader.fixed(1));
    check(h.region_level >= 1 && h.region_level_count >= 1 &&
              h.region_level + h.region_level_count <= h.level_count,
          "3.3.4");
  }
  if (h.level_count > 0) h.tangential_code = static_cast<int>(reader.fixed(1));
  for (int l = 0; l < h.level_count; ++l) h.step_code[l] = static_cast<int>(reader.fixed(1));
  for (int l = 0; l < h.level_count; ++l) {
    check((h.tension_code[l] = flags & 4 ? static_cast<int>(reader.fixed(1)) : 4) <= 8, "3.3.4");
  }

  if (flags & 2) {  // 10.1
    const u64 count = reader.fixed(1);
    check(count >= 1 && count <= 4, "10.1");
    for (u64 i = 0; i < count; ++i) h.attributes.push_back(read_attribute(reader, h.level_count));
  }

  const u64 row_count = reader.varint();  // 3.3.5
  check(row_count >= 1 && row_count <= 1024, "3.3.5");
  for (u64 i = 0; i < row_count; ++i) {
    LayerTableRow row;
    row.size = reader.varint();
    row.level = static_cast<u32>(reader.fixed(1));
    reader.fixed(4);  // rms, max
    row.region = flags & 16 ? static_cast<u32>(reader.fixed(1)) : 0;
    check(row.size > 0 && row.size < (u64{1} << 40) && row.level <= static_cast<u32>(h.level_count) &&
              row.region <= h.region_count,
          "3.3.5");
    h.rows.push_back(row);
  }
  check(!reader.is_past_end, "3.3");
  check(!reader.is_misspelt, "2.2");
  check(reader.position == size, "3.3");
  return h;
}

// ---- 5.1 Arithmetic code ----

struct ArithmeticDecoder {
  const u8* data;
  std::size_t size;
  std::size_t position = 0, beyond = 0;
  u32 low = 0, high = 0xffffffffu, value = 0;

  ArithmeticDecoder(const u8* payload, std::size_t payload_size) : data(payload), size(payload_size) {
    for (int i = 0; i < 4; ++i) value = value << 8 | next_byte();
  }
  u32 next_byte() {
    if (position < size) return data[position++];
    ++beyond;
    return 0;
  }
  int decision(u32 probability) {
    const u32 middle = low + static_cast<u32>((u64{high} - low) * probability >> 16);
    const int bit = value <= middle;
    if (bit) {
      high = middle;
    } else {
      low = middle + 1;
    }
    while (low >> 24 == high >> 24) {
      low <<= 8;
      high = high << 8 | 255;
      value = value << 8 | next_byte();
    }
    return bit;
  }
  int even_bit() { return decision(32768); }
  bool has_ended_early() const { return beyond > 4; }
};

/// Runs one part of a payload. That it ended early comes before every other error (5.1).
template <class Part>
void decode_part(const ArithmeticDecoder& code, const Part& part) {
  try {
    part();
  } catch (const Failure&) {
    check(!code.has_ended_early(), "5.1");
    throw;
  }
  check(!code.has_ended_early(), "5.1");
}

// ---- B.1, B.2 ----

constexpr int kSquash[65] = {22,    28,    36,    47,    60,    77,    98,    126,   162,   208,   267,
                             342,   439,   562,   720,   922,   1179,  1506,  1921,  2446,  3108,  3938,
                             4971,  6249,  7812,  9702,  11955, 14595, 17625, 21025, 24743, 28693, 32768,
                             36843, 40793, 44511, 47911, 50941, 53581, 55834, 57724, 59287, 60565, 61598,
                             62428, 63090, 63615, 64030, 64357, 64614, 64816, 64974, 65097, 65194, 65269,
                             65328, 65374, 65410, 65438, 65459, 65476, 65489, 65500, 65508, 65514};

}  // namespace

int squash(int x) {
  const int y = x + 2048, c = y >> 6, w = y & 63;
  return (kSquash[c] * (64 - w) + kSquash[c + 1] * w) >> 6;
}

int stretch(int p) {
  static const std::vector<int> table = [] {
    std::vector<int> smallest(4096, 2047);
    int x = -2047;
    for (int q = 0; q < 4096; ++q) {
      while (x <= 2047 && squash(x) >> 4 < q) ++x;
      smallest[static_cast<std::size_t>(q)] = std::min(x, 2047);
      if (x > 2047) break;
    }
    return smallest;
  }();
  return table[static_cast<std::size_t>(p >> 4)];
}

namespace {

// ---- 5.2 Probabilities ----

constexpr u32 kSlow = 250, kFast = 120;  // the two count limits

struct AdaptiveBit {  // 5.2.1
  i64 p = 1 << 21;
  u32 n = 0;

  void update(int bit, u32 limit) {
    p += (((bit ? (1 << 22) - 1 : 0) - p) * (131072 / (2 * n + 3))) >> 16;
    if (n < limit) ++n;
  }
  int decode(ArithmeticDecoder& code, u32 limit = kFast) {
    const int bit = code.decision(static_cast<u32>(clamp(p >> 6, 32, 65504)));
    update(bit, limit);
    return bit;
  }
};

struct Mixer {  // 5.2.2
  std::vector<i64> weight;
  i64 rate = 800;

  void start_trained(int row, int input_count) {  // D.3
    weight.clear();
    for (int i = 0; i <= input_count; ++i) weight.push_back(512 * i64{kTrainedWeights[row][i]});
    rate = 300;
  }

  int decode(ArithmeticDecoder& code, const std::vector<AdaptiveBit*>& inputs, u32 limit) {
    const std::size_t m = inputs.size();
    if (weight.empty()) {
      weight.assign(m, 90000 / static_cast<i64>(m));
      weight.push_back(0);
    }
    std::vector<i64> s(m + 1, 77);
    i64 sum = 0;
    for (std::size_t i = 0; i < m; ++i) {
      s[i] =
          (stretch(static_cast<int>(inputs[i]->p >> 6)) * i64{65536 * inputs[i]->n / (inputs[i]->n + 2)}) >>
          16;
    }
    for (std::size_t i = 0; i <= m; ++i) sum += weight[i] * s[i];
    const i64 p = squash(static_cast<int>(clamp(sum >> 16, -2047, 2047)));
    const int bit = code.decision(static_cast<u32>(p));
    const i64 e = (((bit ? 65536 : 0) - p) * rate) >> 10;
    for (std::size_t i = 0; i <= m; ++i)
      weight[i] = clamp(weight[i] + ((e * s[i]) >> 12), -(1 << 22), 1 << 22);
    if (rate > 120) rate -= (rate - 100) >> 5;
    for (AdaptiveBit* input : inputs) input->update(bit, limit);
    return bit;
  }
};

/// The states of D.1 and D.2 in their order: a letter is a trained state, a number that many untrained ones.
class TrainedStates {
 public:
  explicit TrainedStates(const char* text) : at_(text) {}

  /// A table of states for each of `level_count` levels; only the first `told_apart` have letters of their
  /// own.
  void start(AdaptiveBit* states, int count, int level_count = 1, int told_apart = 1) {
    for (int i = 0; i < level_count * count; ++i) {
      if (i < told_apart * count)
        states[i] = next();
      else
        states[i] = states[i - count];
    }
  }

 private:
  AdaptiveBit next() {
    AdaptiveBit bit;
    if (untrained_ == 0 && *at_ >= '0' && *at_ <= '9') {
      char* end = nullptr;
      untrained_ = std::strtol(at_, &end, 10);
      at_ = end;
    }
    if (untrained_ > 0) {
      --untrained_;
      return bit;
    }
    constexpr char kAlphabet[] =
        "!#$%&'()*+,-./:;<=>?@ABCDEFGHIJKLMNOPQRSTUVWXYZ[]^_abcdefghijklmnopqrstuvwxyz{|}~";
    const int letter = static_cast<int>(std::strchr(kAlphabet, *at_++) - kAlphabet) - 40;
    bit.p = i64{squash(51 * letter)} << 6;
    bit.n = 30;
    return bit;
  }

  const char* at_;
  long untrained_ = 0;
};

struct Number {  // 5.2.3
  AdaptiveBit longer[32], first[33];

  u32 decode(ArithmeticDecoder& code) {
    int length = 0;
    while (length < 32 && longer[length].decode(code)) ++length;
    u64 n = 1;
    for (int i = length - 1; i >= 0; --i) {
      n = 2 * n + static_cast<u64>(i == length - 1 ? first[length].decode(code) : code.even_bit());
    }
    return static_cast<u32>(n - 1);
  }
};

constexpr i64 kLargestCoefficient = (1 << 26) - 1;

struct SignedNumber {
  Number number;
  AdaptiveBit sign;

  i64 decode(ArithmeticDecoder& code) {
    const i64 magnitude = std::min<i64>(number.decode(code), 2 * kLargestCoefficient);
    if (magnitude == 0) return 0;
    return sign.decode(code) ? -magnitude : magnitude;
  }
};

// ---- 6.1 Numbering ----

/// One level. An edge is directed as in its left face; without a right face it lies on the boundary.
struct Mesh {
  u32 vertex_count = 0;
  std::vector<std::array<u32, 3>> faces, face_edges;  // face_edges: the edge opposite to the corner
  std::vector<std::array<u32, 2>> edges, edge_faces;  // edge_faces: left, right
  std::vector<bool> is_curve;                         // per edge
  std::vector<std::vector<u32>> curves_at;            // per vertex: its curve edges

  u32 face_beyond(u32 edge, u32 face) const {
    return edge_faces[edge][0] == face ? edge_faces[edge][1] : edge_faces[edge][0];
  }
  u32 third_corner(u32 edge, u32 face) const {
    for (const u32 corner : faces[face])
      if (corner != edges[edge][0] && corner != edges[edge][1]) return corner;
    return kNone;
  }
  bool is_boundary(u32 edge) const { return edge_faces[edge][1] == kNone; }
  bool has_curves() const { return std::find(is_curve.begin(), is_curve.end(), true) != is_curve.end(); }
  void find_curves() {
    curves_at.assign(vertex_count, {});
    for (u32 e = 0; e < edges.size(); ++e) {
      if (!is_curve[e]) continue;
      for (const u32 v : edges[e]) curves_at[v].push_back(e);
    }
  }
};

/// Edges of level 0, and the checks at the end of 4.4.
void find_edges(Mesh& mesh) {
  std::map<std::pair<u32, u32>, u32> number_of;  // both directions of each edge
  for (const auto& f : mesh.faces) check(f[0] != f[1] && f[1] != f[2] && f[2] != f[0], "4.4");
  for (u32 face = 0; face < mesh.faces.size(); ++face) {
    const auto& f = mesh.faces[face];
    mesh.face_edges.push_back({});
    for (u32 k = 0; k < 3; ++k) {
      const u32 a = f[(k + 1) % 3], b = f[(k + 2) % 3];
      const auto found = number_of.find({a, b});
      if (found == number_of.end()) {
        const u32 e = static_cast<u32>(mesh.edges.size());
        number_of[{a, b}] = number_of[{b, a}] = e;
        mesh.edges.push_back({a, b});
        mesh.edge_faces.push_back({face, kNone});
        mesh.face_edges[face][k] = e;
      } else {
        const u32 e = found->second;
        check(mesh.edges[e][0] == b && mesh.edge_faces[e][1] == kNone, "4.4");
        mesh.edge_faces[e][1] = face;
        mesh.face_edges[face][k] = e;
      }
    }
  }
  std::vector<std::vector<u32>> faces_at(mesh.vertex_count);
  for (u32 face = 0; face < mesh.faces.size(); ++face)
    for (const u32 v : mesh.faces[face]) faces_at[v].push_back(face);
  for (u32 v = 0; v < mesh.vertex_count; ++v) {
    check(!faces_at[v].empty(), "4.4");
    check(faces_at[v].size() <= 256, "8");
    // One umbrella: all faces are reached from the first across edges at v.
    std::vector<u32> reached = {faces_at[v][0]};
    for (std::size_t i = 0; i < reached.size(); ++i) {
      for (u32 k = 0; k < 3; ++k) {
        if (mesh.faces[reached[i]][k] == v) continue;  // the edge opposite to v
        const u32 beyond = mesh.face_beyond(mesh.face_edges[reached[i]][k], reached[i]);
        if (beyond != kNone && std::find(reached.begin(), reached.end(), beyond) == reached.end())
          reached.push_back(beyond);
      }
    }
    check(reached.size() == faces_at[v].size(), "4.4");
  }
  mesh.is_curve.resize(mesh.edges.size());
  for (u32 e = 0; e < mesh.edges.size(); ++e) mesh.is_curve[e] = mesh.is_boundary(e);
}

Mesh split(const Mesh& coarse) {
  const u32 V = coarse.vertex_count, E = static_cast<u32>(coarse.edges.size());
  const u32 F = static_cast<u32>(coarse.faces.size());
  Mesh fine;
  fine.vertex_count = V + E;
  fine.edges.resize(2 * E + 3 * F);
  fine.edge_faces.assign(2 * E + 3 * F, {kNone, kNone});
  fine.is_curve.assign(2 * E + 3 * F, false);
  for (u32 e = 0; e < E; ++e) {
    fine.edges[2 * e] = {coarse.edges[e][0], V + e};
    fine.edges[2 * e + 1] = {V + e, coarse.edges[e][1]};
    fine.is_curve[2 * e] = fine.is_curve[2 * e + 1] = coarse.is_curve[e];
  }
  for (u32 f = 0; f < F; ++f) {
    const auto& v = coarse.faces[f];
    const auto& e = coarse.face_edges[f];
    const std::array<u32, 3> m = {V + e[0], V + e[1], V + e[2]};
    fine.faces.push_back({v[0], m[2], m[1]});
    fine.faces.push_back({m[2], v[1], m[0]});
    fine.faces.push_back({m[1], m[0], v[2]});
    fine.faces.push_back(m);
    for (u32 k = 0; k < 3; ++k) {
      fine.edges[2 * E + 3 * f + k] = {m[(k + 1) % 3], m[(k + 2) % 3]};
      fine.edge_faces[2 * E + 3 * f + k] = {4 * f + 3, 4 * f + k};
    }
    const auto half = [&](u32 k, u32 end) { return 2 * e[k] + (coarse.edges[e[k]][0] == v[end] ? 0 : 1); };
    const auto inner = [&](u32 k) { return 2 * E + 3 * f + k; };
    fine.face_edges.push_back({inner(0), half(1, 0), half(2, 0)});
    fine.face_edges.push_back({half(0, 1), inner(1), half(2, 1)});
    fine.face_edges.push_back({half(0, 2), half(1, 2), inner(2)});
    fine.face_edges.push_back({inner(0), inner(1), inner(2)});
    for (u32 child = 0; child < 3; ++child) {
      for (u32 k = 0; k < 3; ++k) {
        if (k == child) continue;
        const u32 side = coarse.edge_faces[e[k]][0] == f ? 0 : 1;
        fine.edge_faces[half(k, child)][side] = 4 * f + child;
      }
    }
  }
  fine.find_curves();
  return fine;
}

// ---- 4.4 Connectivity ----

struct BaseMeshDecoder {
  AdaptiveBit is_new[10][10], is_new_u[10], is_new_v[10];  // A, B, C of A.6
  Mixer is_new_mixer;
  AdaptiveBit is_left[10], is_right[10], is_boundary[3], is_near, side;
  Number distance;
  AdaptiveBit crease[4];
  AdaptiveBit length[3][40], below_leading[40], sign[3][3];
  Number correction;
  AdaptiveBit correction_sign;

  BaseMeshDecoder() {  // D.1
    TrainedStates states(kTrainedBaseStates);
    states.start(&is_new[0][0], 100);
    for (AdaptiveBit* row : {is_new_u, is_new_v, is_left, is_right}) states.start(row, 10);
    states.start(is_boundary, 3);
    states.start(&is_near, 1);
    states.start(&side, 1);
    states.start(&length[0][0], 120);
    states.start(below_leading, 40);
    states.start(&sign[0][0], 9);
    is_new_mixer.start_trained(11, 3);
  }

  enum class State { kOpen, kBoundary, kGone };
  struct BorderEdge {
    u32 start, next, previous;
    State state;
  };

  void decode_connectivity(ArithmeticDecoder& code, u32 vertex_count, u32 face_count, Mesh& mesh) {
    std::vector<BorderEdge> border;
    std::vector<u32> faces_around(vertex_count);
    u32 n = 0;  // vertices so far
    const auto add_face = [&](u32 a, u32 b, u32 c) {
      check(mesh.faces.size() < face_count, "4.4");
      mesh.faces.push_back({a, b, c});
      for (const u32 v : {a, b, c}) ++faces_around[v];
    };
    const auto link = [&](u32 from, u32 to) {
      border[from].next = to;
      border[to].previous = from;
    };
    const auto close_if_two = [&](u32 edge) {
      const u32 other = border[edge].next;
      if (border[other].next != edge) return;
      check(border[edge].state == State::kOpen && border[other].state == State::kOpen, "4.4");
      border[edge].state = border[other].state = State::kGone;
    };
    std::size_t handled = 0;
    while (mesh.faces.size() < face_count) {
      check(vertex_count - n >= 3, "4.4");
      const u32 first = static_cast<u32>(border.size());
      for (const u32 start : {n, n + 2, n + 1}) border.push_back({start, 0, 0, State::kOpen});
      link(first, first + 1);
      link(first + 1, first + 2);
      link(first + 2, first);
      add_face(n, n + 1, n + 2);
      n += 3;
      for (; handled < border.size(); ++handled) {
        const u32 i = static_cast<u32>(handled);
        while (border[i].state == State::kOpen) {
          const u32 next = border[i].next, previous = border[i].previous;
          const u32 u = border[i].start, v = border[next].start;
          const u32 du = std::min(faces_around[u], 9u), dv = std::min(faces_around[v], 9u);
          const bool left_is_open = border[previous].state == State::kOpen;
          const bool right_is_open = border[next].state == State::kOpen;
          const u32 added = static_cast<u32>(border.size());
          if (is_new_mixer.decode(code, {&is_new[du][dv], &is_new_u[du], &is_new_v[dv]}, kFast)) {  // 1
            check(n < vertex_count, "4.4");
            add_face(u, v, n);
            border.push_back({n++, 0, 0, State::kOpen});
            link(i, added);
            link(added, next);
          } else if (left_is_open && is_left[du].decode(code)) {  // 2
            add_face(u, v, border[previous].start);
            border[i].state = State::kGone;
            link(previous, next);
            close_if_two(previous);
          } else if (right_is_open && is_right[dv].decode(code)) {  // 3
            add_face(u, v, border[border[next].next].start);
            border[next].state = State::kGone;
            link(i, border[next].next);
            close_if_two(i);
          } else if (is_boundary[!left_is_open + !right_is_open].decode(code)) {  // 4
            border[i].state = State::kBoundary;
          } else {  // 5
            u32 place = 0;
            if (is_near.decode(code)) {
              const bool is_backwards = side.decode(code);
              const u32 steps = distance.decode(code);
              check(steps < 32, "4.4");
              place = is_backwards ? previous : border[next].next;
              for (u32 s = 0; s < steps; ++s)
                place = is_backwards ? border[place].previous : border[place].next;
            } else {
              for (int bit = bit_length(border.size() - 1); bit > 0; --bit) {
                place = 2 * place + static_cast<u32>(code.even_bit());
              }
              check(place < border.size(), "4.4");
            }
            const u32 w = border[place].start;
            check(border[place].state != State::kGone && place != i && place != next && w != u && w != v,
                  "4.4");
            add_face(u, v, w);
            border.push_back({w, 0, 0, State::kOpen});
            link(border[place].previous, added);
            link(added, next);
            link(i, place);
            close_if_two(i);
            close_if_two(added);
          }
        }
      }
    }
    check(n == vertex_count, "4.4");
    mesh.vertex_count = vertex_count;
    find_edges(mesh);
  }

  // ---- 4.5 Creases ----

  std::vector<u8> decode_creases(ArithmeticDecoder& code, Mesh& mesh) {
    std::vector<u8> is_crease(mesh.edges.size());
    std::vector<int> at(mesh.vertex_count);
    for (u32 e = 0; e < mesh.edges.size(); ++e) {
      if (mesh.is_boundary(e)) continue;
      int &a = at[mesh.edges[e][0]], &b = at[mesh.edges[e][1]];
      const int context = (a == 1) + (b == 1) + 3 * (a > 1 && b > 1);
      if (!crease[context].decode(code)) continue;
      is_crease[e] = 1;
      mesh.is_curve[e] = true;
      a = std::min(a + 1, 3);
      b = std::min(b + 1, 3);
    }
    return is_crease;
  }

  // ---- 4.6 Coordinates ----

  static i64 rounded(i64 x, i64 n) {
    const i64 twice = 2 * x + n, q = twice / (2 * n);
    return twice % (2 * n) < 0 ? q - 1 : q;
  }

  std::vector<i64> decode_coordinates(ArithmeticDecoder& code, const Mesh& mesh) {
    std::vector<i64> x(3 * std::size_t{mesh.vertex_count});
    i64 share = 0, spread = 0;
    for (int i = 0; i < 3; ++i) share = 2 * share + code.even_bit();
    std::vector<std::vector<std::pair<u32, u32>>> corners_at(mesh.vertex_count);  // (face, corner)
    for (u32 f = 0; f < mesh.faces.size(); ++f)
      for (u32 k = 0; k < 3; ++k) corners_at[mesh.faces[f][k]].push_back({f, k});

    for (u32 v = 0; v < mesh.vertex_count; ++v) {
      std::vector<u32> neighbours;
      std::vector<std::array<u32, 3>> parallelograms;
      i64 distances = 0, distance_count = 0;
      for (const auto& [f, k] : corners_at[v]) {
        const u32 a = mesh.faces[f][(k + 1) % 3], b = mesh.faces[f][(k + 2) % 3];
        for (const u32 neighbour : {a, b}) {
          if (neighbour < v && std::find(neighbours.begin(), neighbours.end(), neighbour) == neighbours.end())
            neighbours.push_back(neighbour);
        }
        if (a >= v || b >= v) continue;
        ++distance_count;
        for (u32 i = 0; i < 3; ++i) distances += std::abs(x[3 * a + i] - x[3 * b + i]);
        const u32 edge = mesh.face_edges[f][k], beyond = mesh.face_beyond(edge, f);
        if (beyond == kNone) continue;
        const u32 c = mesh.third_corner(edge, beyond);
        if (c < v) parallelograms.push_back({a, b, c});
      }
      if (distance_count) spread = (2 * distances + distance_count) / (2 * distance_count);
      const int scale = bit_length(static_cast<u64>(std::min<i64>(spread, 0xffffffff)));
      const int kind = !parallelograms.empty() ? 0 : !neighbours.empty() ? 1 : 2;
      const int top = kind == 2 ? 31 : std::min(scale + 1, 30);
      for (u32 i = 0; i < 3; ++i) {
        i64 prediction = v > 0 ? x[3 * (v - 1) + i] : 0, lean = 0;
        if (!neighbours.empty()) {
          i64 sum = 0;
          for (const u32 a : neighbours) sum += x[3 * a + i];
          const i64 mean = rounded(sum, static_cast<i64>(neighbours.size()));
          prediction = mean;
          if (!parallelograms.empty()) {
            sum = 0;
            for (const auto& [a, b, c] : parallelograms) sum += x[3 * a + i] + x[3 * b + i] - x[3 * c + i];
            const i64 point = rounded(sum, static_cast<i64>(parallelograms.size()));
            prediction = rounded((4 - share) * mean + share * point, 4);
            lean = mean - point;
          }
        }
        x[3 * v + i] = prediction + decode_residual(code, kind, top, 1 + sign_of(lean));
        check(std::abs(x[3 * v + i]) < (1 << 28), "4.6");
      }
    }
    return x;
  }

  i64 decode_residual(ArithmeticDecoder& code, int kind, int top, int lean) {
    int bits = top, step = 0;
    if (length[kind][0].decode(code)) {
      step = 33;
      while (bits < 31) {
        ++bits;
        if (!length[kind][33 + std::min(bits - top, 6)].decode(code)) break;
      }
    } else {
      for (; bits > 0; --bits) {
        ++step;
        if (length[kind][std::min(step, 32)].decode(code)) break;
      }
    }
    if (bits == 0) return 0;
    i64 magnitude = 1;
    for (int below = bits - 1; below > 0; --below) {
      magnitude = 2 * magnitude + (below == bits - 1 ? below_leading[step].decode(code) : code.even_bit());
    }
    return sign[kind][lean].decode(code) ? -magnitude : magnitude;
  }

  // ---- 4.7 Corrections ----

  void correct(ArithmeticDecoder& code, i64 ratio, std::vector<i64>& x) {
    for (i64& value : x) check(std::abs(value *= ratio) < (1 << 28), "4.6");
    for (i64& value : x) {
      const i64 magnitude = correction.decode(code);
      if (magnitude) value += correction_sign.decode(code) ? -magnitude : magnitude;
      check(std::abs(value) < (1 << 28), "4.6");
    }
  }
};

}  // namespace

// ---- 5.3 Geometry ----

int energy_class(std::int64_t sixteenths) {
  int reached = 0;
  for (const int bound : {1, 3, 6, 11, 18, 26, 40, 64, 128, 256}) reached += sixteenths >= bound;
  return reached;
}

namespace {

struct Tangential {
  i64 along = 0, across = 0;
};
struct Level {
  int layer = -1;
  std::vector<i64> value;                // one per edge
  std::map<u32, Tangential> tangential;  // by edge
};

/// What is known around an edge (5.3.1).
struct Surroundings {
  i64 near_sum = 0, near_count = 0, far_sum = 0, far_count = 0, parent_sum = 0, opposite_sum = 0;
  i64 near_signs = 0, near_signed = 0, parent_signs = 0, opposite_signs = 0, largest = 0;
  std::array<int, 4> near_digits = {5, 5, 5, 5};

  u32 neighbour_index() const {
    std::array<int, 4> d = near_digits;
    std::sort(d.begin(), d.end());
    return static_cast<u32>(d[0] + 6 * (d[1] + 6 * (d[2] + 6 * d[3])));
  }
};

i64 cut(i64 value) { return std::min<i64>(std::abs(value), 1023); }

/// The tables of A.2 to A.5, with the same names.
struct BlockStates {
  AdaptiveBit by_run[8][11], by_around[10][11], by_corners[8][11][2], by_last[8][4][10];
  Mixer mixer[8];
};
struct SignificanceStates {
  AdaptiveBit by_energy[8][4][11], by_neighbours[8][1296], by_parents[8][11][11], by_far_ring[12][11];
  AdaptiveBit by_run[8][11], by_all[11][11][12], by_sibling[8][4][5][11];
  Mixer mixer[8][4];
};
struct SignStates {
  AdaptiveBit by_neighbours[9], by_parents[8][5], by_opposite[5][5], by_signed[25][3][2], by_all[9][5][5];
  AdaptiveBit by_sibling[3][5];
  Mixer mixer[3];
};
struct MagnitudeStates {
  AdaptiveBit by_energy[11][14], by_far_ring[12][14], by_parents[8][11][14], by_largest[7][14];
  AdaptiveBit by_level_energy[8][11][14], by_sib[5][2][14];
  Mixer mixer[14];
  Number escape;
};

struct GeometryDecoder {
  BlockStates half_blocks[2], inner_blocks[2];
  SignificanceStates significance[2];
  SignStates sign[2];
  MagnitudeStates magnitude[2];
  u32 last_half = 0, last_inner = 0;
  i64 run = 16;
  SignedNumber curve_across[3];
  Number tangential_count[2], gap;
  SignedNumber along, across;

  GeometryDecoder() {  // D.2
    TrainedStates states(kTrainedCoefficientStates);
    SignificanceStates& zero = significance[0];
    states.start(&zero.by_energy[0][0][0], 44, 8, 3);
    states.start(&zero.by_neighbours[0][0], 1296, 8, 1);
    states.start(&zero.by_parents[0][0][0], 121, 8, 3);
    states.start(&zero.by_far_ring[0][0], 132);
    states.start(&zero.by_run[0][0], 11, 8, 3);
    states.start(&zero.by_all[0][0][0], 1452);
    states.start(&zero.by_sibling[0][0][0][0], 220, 8, 3);
    SignStates& signs = sign[0];
    states.start(&signs.by_neighbours[0], 9);
    states.start(&signs.by_parents[0][0], 5, 8, 1);
    states.start(&signs.by_opposite[0][0], 25);
    states.start(&signs.by_signed[0][0][0], 150);
    states.start(&signs.by_all[0][0][0], 225);
    states.start(&signs.by_sibling[0][0], 15);
    MagnitudeStates& more = magnitude[0];
    states.start(&more.by_energy[0][0], 154);
    states.start(&more.by_far_ring[0][0], 168);
    states.start(&more.by_parents[0][0][0], 154, 8, 3);
    states.start(&more.by_largest[0][0], 98);
    states.start(&more.by_level_energy[0][0][0], 154, 8, 3);
    states.start(&more.by_sib[0][0][0], 140);
    for (BlockStates* open : {&half_blocks[0], &inner_blocks[0]}) {
      states.start(&open->by_run[0][0], 11, 8, 3);
      states.start(&open->by_around[0][0], 110);
      states.start(&open->by_corners[0][0][0], 22, 8, 3);
      states.start(&open->by_last[0][0][0], 40, 8, 3);
    }
    for (auto& kinds : zero.mixer)  // D.3
      for (int kind = 0; kind < 4; ++kind) kinds[kind].start_trained(kind, 7);
    for (int kind = 0; kind < 2; ++kind) signs.mixer[kind].start_trained(4 + kind, 6);
    for (int m = 0; m < 14; ++m) more.mixer[m].start_trained(6 + std::min(m, 2), 6);
    for (Mixer& mixer : half_blocks[0].mixer) mixer.start_trained(9, 4);
    for (Mixer& mixer : inner_blocks[0].mixer) mixer.start_trained(10, 4);
  }

  // The level at hand.
  int level_class = 0;
  const Mesh* mesh = nullptr;
  const std::vector<i64>* inserted = nullptr;  // per vertex: the integer with which it was inserted
  bool has_before = false;
  std::vector<i64> before;  // per edge
  std::vector<i64> value;
  std::vector<bool> is_foreign;  // per edge of the coarser level, in a region (5.4); else empty
  bool is_half_foreign(u32 edge) const { return edge / 2 < is_foreign.size() && is_foreign[edge / 2]; }

  bool is_known(u32 edge, u32 at) const { return edge < at || has_before; }
  i64 known(u32 edge, u32 at) const { return edge < at ? value[edge] : before[edge]; }

  Surroundings look_around(u32 edge) const {  // 5.3.1
    Surroundings s;
    std::size_t place = 0;
    for (const u32 v : mesh->edges[edge]) {
      s.parent_sum += cut((*inserted)[v]);
      s.parent_signs += sign_of((*inserted)[v]);
    }
    for (const u32 face : mesh->edge_faces[edge]) {
      if (face == kNone) continue;
      const i64 opposite = (*inserted)[mesh->third_corner(edge, face)];
      s.opposite_sum += cut(opposite);
      s.opposite_signs += sign_of(opposite);
      for (const u32 near : mesh->face_edges[face]) {
        if (near == edge) continue;
        if (is_known(near, edge)) {
          const i64 v = known(near, edge);
          s.near_sum += cut(v);
          ++s.near_count;
          s.near_signs += sign_of(v);
          s.near_signed += clamp(v, -3, 3);
          s.largest = std::max(s.largest, cut(v));
          s.near_digits[place++] = static_cast<int>(std::min<i64>(cut(v), 3));
        } else {
          s.near_digits[place++] = 4;
        }
        const u32 beyond = mesh->face_beyond(near, face);
        if (beyond == kNone) continue;
        for (const u32 far : mesh->face_edges[beyond]) {
          if (far == near || !is_known(far, edge)) continue;
          s.far_sum += cut(known(far, edge));
          ++s.far_count;
        }
      }
    }
    return s;
  }

  /// 5.3.3. `kind` is that of A.1.
  i64 decode_value(ArithmeticDecoder& code, u32 edge, int kind, bool is_known_nonzero) {
    const Surroundings s = look_around(edge);
    const int L = level_class;
    const i64 inherited = 64 * s.parent_sum + 24 * s.opposite_sum;
    const i64 energy = L == 0         ? (s.near_count ? 16 * s.near_sum / s.near_count : 16)
                       : s.near_count ? (320 * s.near_sum / s.near_count + inherited) / 31
                                      : inherited / 11;
    const int energy_of = energy_class(energy), run_of = energy_class(run);
    const int parent_of = energy_class(8 * s.parent_sum), opposite_of = energy_class(8 * s.opposite_sum);
    const int far_of = s.far_count ? energy_class(16 * s.far_sum / s.far_count) : 11;
    const i64 sibling = edge > 0 ? value[edge - 1] : 0;
    const int sibling_of = edge > 0 ? static_cast<int>(std::min<i64>(std::abs(sibling), 3)) : 4;
    const i64 old = before[edge];
    const int set = old != 0;

    if (!is_known_nonzero) {  // A.3
      SignificanceStates& t = significance[set];
      const int is_significant = t.mixer[L][kind].decode(
          code,
          {&t.by_energy[L][kind][energy_of], &t.by_neighbours[L][s.neighbour_index()],
           &t.by_parents[L][parent_of][opposite_of], &t.by_far_ring[far_of][energy_of], &t.by_run[L][run_of],
           &t.by_all[energy_of][parent_of][far_of], &t.by_sibling[L][kind][sibling_of][parent_of]},
          kSlow);
      if (!is_significant) {
        run -= run >> 3;
        return old;
      }
    }

    SignStates& g = sign[set];  // A.4
    const i64 near = s.near_signs + 4, parents = s.parent_signs + 2, opposites = s.opposite_signs + 2;
    const int is_negative = g.mixer[kind & 1].decode(
        code,
        {&g.by_neighbours[near], &g.by_parents[L][parents], &g.by_opposite[opposites][parents],
         &g.by_signed[s.near_signed + 12][sign_of(sibling) + 1][kind & 1],
         &g.by_all[near][parents][opposites], &g.by_sibling[sign_of(sibling) + 1][opposites]},
        kSlow);

    MagnitudeStates& q = magnitude[set];  // A.5
    const i64 largest_of = s.near_count ? std::min<i64>(s.largest, 5) : 6;
    i64 m = 0;
    while (m < 14 &&
           q.mixer[m].decode(code,
                             {&q.by_energy[energy_of][m], &q.by_far_ring[far_of][m],
                              &q.by_parents[L][parent_of][m], &q.by_largest[largest_of][m],
                              &q.by_level_energy[L][energy_of][m], &q.by_sib[sibling_of][kind & 1][m]},
                             kFast)) {
      ++m;
    }
    if (m == 14) m += q.escape.decode(code);
    const i64 t = std::min(m + 1, 2 * kLargestCoefficient);
    run += 2 * std::min<i64>(t, 64) - (run >> 3);
    return clamp(old + (old < 0 ? -1 : 1) * (is_negative ? -t : t), -kLargestCoefficient,
                 kLargestCoefficient);
  }

  /// 5.3.2: one block of `count` values from `first` on, with what A.2 needs of a quiet one.
  void decode_block(ArithmeticDecoder& code, u32 first, u32 count, bool is_quiet, i64 ends, i64 wide) {
    const int kind = count == 3;
    bool is_open = false;
    if (is_quiet) {
      BlockStates& t = (count == 3 ? inner_blocks : half_blocks)[has_before];
      u32& last = count == 3 ? last_inner : last_half;
      const int L = level_class, run_of = energy_class(run), ends_of = energy_class(8 * ends);
      wide = std::min<i64>(wide, 9);
      is_open = t.mixer[L].decode(code,
                                  {&t.by_run[L][run_of], &t.by_around[wide][ends_of],
                                   &t.by_corners[L][ends_of][last & 1], &t.by_last[L][last & 3][wide]},
                                  kSlow);
      last = 2 * last + is_open;
      if (!is_open) {
        for (u32 i = 0; i < count; ++i) {
          value[first + i] = 0;
          run -= run >> 3;
        }
        return;
      }
    }
    bool all_zero = true;
    for (u32 i = 0; i < count; ++i) {
      value[first + i] =
          decode_value(code, first + i, kind + 2 * is_open, is_open && i + 1 == count && all_zero);
      all_zero = all_zero && value[first + i] == 0;
    }
  }

  void decode_pair(ArithmeticDecoder& code, const Mesh& coarse, u32 e) {
    const auto& [a, b] = coarse.edges[e];
    const auto of_edge = [&](u32 edge) { return cut((*inserted)[coarse.vertex_count + edge]); };
    const auto half_value = [&](u32 half) { return half < 2 * e ? cut(value[half]) : cut(before[half]); };
    i64 quiet = of_edge(e) + cut(before[2 * e]) + cut(before[2 * e + 1]), wide = 0;
    for (const u32 face : coarse.edge_faces[e]) {
      if (face == kNone) continue;
      for (const u32 near : coarse.face_edges[face]) {
        if (near == e) continue;
        const u32 start = coarse.edges[near][0];
        const u32 shared = start == a || start == b ? 0 : 1;
        quiet += of_edge(near) + half_value(2 * near + shared);
        wide += half_value(2 * near + 1 - shared);
      }
    }
    decode_block(code, 2 * e, 2, quiet == 0, cut((*inserted)[a]) + cut((*inserted)[b]), wide);
  }

  void decode_triple(ArithmeticDecoder& code, const Mesh& coarse, u32 f) {
    const u32 inner = 2 * static_cast<u32>(coarse.edges.size()), first = inner + 3 * f;
    i64 quiet = 0, wide = 0, ends = 0;
    for (u32 k = 0; k < 3; ++k) {
      const u32 e = coarse.face_edges[f][k];
      quiet += cut((*inserted)[coarse.vertex_count + e]) + cut(value[2 * e]) + cut(value[2 * e + 1]);
      quiet += cut(before[first + k]);
      ends += cut((*inserted)[coarse.faces[f][k]]);
      const u32 other = coarse.face_beyond(e, f);
      if (other == kNone) continue;
      for (u32 j = 0; j < 3; ++j) wide += cut((other < f ? value : before)[inner + 3 * other + j]);
    }
    decode_block(code, first, 3, quiet == 0, ends, wide);
  }

  void decode_tangential(ArithmeticDecoder& code, i64 ratio, std::map<u32, Tangential>& list) {  // 5.3.4
    std::map<u32, Tangential> corrections;
    const u32 edge_count = static_cast<u32>(mesh->edges.size());
    int context = 0;
    for (u32 e = 0; e < edge_count; ++e) {
      if (!mesh->is_curve[e] || is_half_foreign(e)) continue;
      const i64 c = curve_across[context].decode(code);
      context = c == 0 ? 0 : std::abs(c) < 3 ? 1 : 2;
      if (c != 0) corrections[e].across = c;
    }
    const u32 count = tangential_count[has_before].decode(code);
    check(count <= edge_count, "5.3.4");
    u32 lowest = 0;
    for (u32 i = 0; i < count; ++i) {
      check(lowest < edge_count, "5.3.4");
      const u32 skipped = gap.decode(code);
      check(skipped < edge_count - lowest, "5.3.4");
      const u32 e = lowest + skipped;
      check(!is_half_foreign(e), "5.4");
      corrections[e].along = along.decode(code);
      if (!mesh->is_curve[e]) corrections[e].across = across.decode(code);
      lowest = e + 1;
    }
    const auto held = [](i64 x) { return clamp(x, -kLargestCoefficient, kLargestCoefficient); };
    for (auto& [e, t] : list) t = {held(ratio * t.along), held(ratio * t.across)};
    for (const auto& [e, c] : corrections) {
      Tangential& t = list[e];
      t = {held(t.along + c.along), held(t.across + c.across)};
    }
    std::erase_if(list,
                  [](const auto& entry) { return entry.second.along == 0 && entry.second.across == 0; });
  }

  void decode_level(ArithmeticDecoder& code, int level, const Mesh* coarse, const Mesh& topology,
                    const std::vector<i64>& inserted_values, i64 ratio, Level& result) {
    level_class = std::min(level, 7);
    mesh = &topology;
    inserted = &inserted_values;
    has_before = result.layer >= 0;
    before.assign(topology.edges.size(), 0);
    for (std::size_t e = 0; e < result.value.size(); ++e) {
      before[e] = clamp(ratio * result.value[e], -kLargestCoefficient, kLargestCoefficient);
    }
    value.assign(topology.edges.size(), 0);
    if (!coarse) {
      for (u32 e = 0; e < topology.edges.size(); ++e) value[e] = decode_value(code, e, 0, false);
    } else {
      for (u32 e = 0; e < coarse->edges.size(); ++e)
        if (!is_half_foreign(2 * e)) decode_pair(code, *coarse, e);
      for (u32 f = 0; f < coarse->faces.size(); ++f) decode_triple(code, *coarse, f);
    }
    decode_tangential(code, ratio, result.tangential);
    result.value = value;
  }
};

// ---- 6 Reconstruction, with the arithmetic of 7 ----

struct Vec3 {
  double x = 0, y = 0, z = 0;
};
Vec3 operator+(const Vec3& a, const Vec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
Vec3 operator-(const Vec3& a, const Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Vec3 operator*(double s, const Vec3& a) { return {s * a.x, s * a.y, s * a.z}; }
Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
Vec3 unit(const Vec3& v, const Vec3& otherwise) {
  const double length = std::sqrt((v.x * v.x + v.y * v.y) + v.z * v.z);
  return length > 0 ? Vec3{v.x / length, v.y / length, v.z / length} : otherwise;
}

}  // namespace

double cosine(std::uint32_t i, std::uint32_t n) {  // A.7
  i %= n;
  if (2 * i > n) i = n - i;
  double sign = 1;
  u32 q = 4 * i;
  if (q > n) {
    sign = -1;
    q = 2 * n - q;
  }
  const bool sine = 2 * q > n;
  const double x =
      (6.283185307179586 * 0.25) * (static_cast<double>(sine ? n - q : q) / static_cast<double>(n));
  const double xx = x * x;
  double term = sine ? x : 1.0, sum = term;
  for (int k = sine ? 2 : 1; k < 20; k += 2) {
    term = -(term * xx) / static_cast<double>(k * (k + 1));
    sum = sum + term;
  }
  return sign * sum;
}

double step_of_code(double step, int code) {  // 3.3.4
  const int eighths = code - 64;
  return std::ldexp(step * kEighthRoots[eighths & 7], eighths >> 3);
}

namespace {

// ---- 10 Attributes ----

/// What is known of one component of a vertex before it is decoded (10.4, 10.5.1).
struct AttributeContext {
  i64 prediction = 0, interpolation = 0;
  int near = 11, slope = 0, bend = 11;
  i32 sign = 0, bend_sign = 0;
};

struct AttributeDecoder {
  std::vector<std::array<i64, 4>> values;  // as coded, per vertex
  int next_level = 0;

  void decode_level_0(ArithmeticDecoder& code, const AttributeTable& table, const Mesh& base) {
    std::vector<std::vector<u32>> lower(base.vertex_count);
    for (const auto& [a, b] : base.edges) lower[std::max(a, b)].push_back(std::min(a, b));
    i64 run[4] = {};
    for (u32 v = 0; v < base.vertex_count; ++v) {
      const i64 n = static_cast<i64>(lower[v].size());
      std::array<AttributeContext, 4> contexts;
      for (u32 c = 0; c < table.components; ++c) {
        AttributeContext& context = contexts[c];
        const i64 step = table.level[0].step[c];
        context.near = energy_class(steps(run[c], step));
        if (n > 0) {
          i64 sum = 0, least = 1 << 20, largest = -(1 << 20);
          for (const u32 u : lower[v]) {
            sum += values[u][c];
            least = std::min(least, values[u][c]);
            largest = std::max(largest, values[u][c]);
          }
          context.prediction = BaseMeshDecoder::rounded(sum, n);
          context.slope = energy_class(steps(4 * (largest - least), step));
          context.bend = 0;
        } else {
          const i64 high = table.held(1 << 20, c), low = table.held(-(1 << 20), c);
          context.prediction = v > 0 ? values[v - 1][c] : (low + high + 1) >> 1;
        }
      }
      decode_vertex(code, table, 0, static_cast<int>(std::min<i64>(n, 4)), contexts);
      for (u32 c = 0; c < table.components; ++c)
        run[c] += 2 * std::abs(values[v][c] - contexts[c].prediction) - (run[c] >> 3);
    }
  }

  void decode_level(ArithmeticDecoder& code, const AttributeTable& table, int level, const Mesh& coarse) {
    std::vector<std::array<i64, 4>> deviations;
    values.resize(coarse.vertex_count);
    for (u32 e = 0; e < coarse.edges.size(); ++e) {
      std::vector<u32> near;
      for (const u32 face : coarse.edge_faces[e]) {
        if (face == kNone) continue;
        for (const u32 other : coarse.face_edges[face])
          if (other < e) near.push_back(other);
      }
      const i64 inverse = std::array<i64, 5>{0, 64, 32, 21, 16}[near.size()];
      std::array<AttributeContext, 4> contexts;
      for (u32 c = 0; c < table.components; ++c) {
        AttributeContext& context = contexts[c];
        const i64 step = table.level[level].step[c];
        i64 sum = 0, magnitudes = 0;
        for (const u32 other : near) {
          sum += deviations[other][c];
          magnitudes += std::abs(deviations[other][c]);
        }
        const i64 a = values[coarse.edges[e][0]][c], b = values[coarse.edges[e][1]][c];
        context.interpolation = interpolation(table, level, coarse, e, c);
        context.prediction = table.held(
            context.interpolation + ((table.level[level].near_share * sum * inverse + 512) >> 10), c);
        if (!near.empty()) context.near = energy_class(steps((magnitudes * inverse) >> 2, step));
        context.sign = sign_of(sum);
        context.slope = energy_class(steps(4 * std::abs(a - b), step));
        if (!coarse.is_boundary(e)) {
          const i64 bend = opposite(coarse, e, c) - (a + b);
          context.bend = energy_class(steps(2 * std::abs(bend), step));
          context.bend_sign = sign_of(bend);
        }
      }
      decode_vertex(code, table, level, static_cast<int>(near.size()), contexts);
      deviations.emplace_back();
      for (u32 c = 0; c < table.components; ++c)
        deviations.back()[c] = values.back()[c] - contexts[c].interpolation;
    }
  }

  /// Sum over the third corners of the faces of an inner edge.
  i64 opposite(const Mesh& coarse, u32 e, u32 c) const {
    i64 sum = 0;
    for (const u32 face : coarse.edge_faces[e]) sum += values[coarse.third_corner(e, face)][c];
    return sum;
  }
  i64 interpolation(const AttributeTable& table, int level, const Mesh& coarse, u32 e, u32 c) const {
    const i64 ends = values[coarse.edges[e][0]][c] + values[coarse.edges[e][1]][c];
    if (coarse.is_boundary(e)) return (ends + 1) >> 1;
    const i64 o = level <= table.finest_level ? table.level[level].opposite_share : 0;
    return table.held(((8 - o) * ends + o * opposite(coarse, e, c) + 8) >> 4, c);
  }

 private:
  static i64 steps(i64 x, i64 step) { return (x * (65536 / step)) >> 16; }

  struct ComponentStates {
    AdaptiveBit zero_near[8][12][5], zero_shape[11][12], zero_others[12][9], zero_slope[12][11],
        zero_level[8][9];
    AdaptiveBit sign_near[3][3], sign_others[3][3][3], sign_shape[3][12];
    AdaptiveBit more_near[12][14], more_slope[11][14], more_others[9][14], more_level[8][14];
    Mixer zero_mixer[8], sign_mixer, more_mixer[14];
    Number escape;
  };

  /// 10.5.2; appends the values of one vertex.
  void decode_vertex(ArithmeticDecoder& code, const AttributeTable& table, int level, int n,
                     const std::array<AttributeContext, 4>& contexts) {
    const int lc = std::min(level, 7);
    const AttributeContext& first = contexts[0];
    int chroma = 0;
    for (u32 c = 1; c < table.components; ++c) chroma = std::max(chroma, contexts[c].near);
    const int open =
        open_mixer_[lc].decode(code,
                               {&open_near_[lc][first.near][n], &open_shape_[first.slope][first.bend],
                                &open_chroma_[first.near][chroma], &open_slope_[first.near][first.slope],
                                &open_history_[history_ & 15][chroma]},
                               kSlow);
    history_ = 2 * history_ + static_cast<u32>(open);
    std::array<i64, 4> q{};
    bool all_zero = true;
    for (u32 c = 0; open && c < table.components; ++c) {
      ComponentStates& states = components_[c];
      const AttributeContext& k = contexts[c];
      const auto small = [&](u32 i) { return static_cast<int>(std::min<i64>(std::abs(q[i]), 2)); };
      const int others = c == 0 ? 0 : c == 1 ? small(0) : 3 * small(0) + small(1);
      const bool is_known = c + 1 == table.components && all_zero;
      if (!is_known && !states.zero_mixer[lc].decode(
                           code,
                           {&states.zero_near[lc][k.near][n], &states.zero_shape[k.slope][k.bend],
                            &states.zero_others[k.near][others], &states.zero_slope[k.near][k.slope],
                            &states.zero_level[lc][others]},
                           kSlow))
        continue;
      all_zero = false;
      const i32 s0 = c > 0 ? sign_of(q[0]) : 0, s1 = c > 1 ? sign_of(q[1]) : 0;
      const int negative = states.sign_mixer.decode(
          code,
          {&states.sign_near[k.sign + 1][k.bend_sign + 1], &states.sign_others[s0 + 1][s1 + 1][k.sign + 1],
           &states.sign_shape[k.bend_sign + 1][k.bend]},
          kSlow);
      u64 more = 0;
      while (more < 14 && states.more_mixer[more].decode(
                              code,
                              {&states.more_near[k.near][more], &states.more_slope[k.slope][more],
                               &states.more_others[others][more], &states.more_level[lc][more]},
                              kFast))
        ++more;
      if (more == 14) more += states.escape.decode(code);
      const i64 magnitude = std::min<i64>(static_cast<i64>(more) + 1, (1 << 15) - 1);
      q[c] = negative ? -magnitude : magnitude;
    }
    values.emplace_back();
    for (u32 c = 0; c < table.components; ++c)
      values.back()[c] = table.held(contexts[c].prediction + table.level[level].step[c] * q[c], c);
  }

  AdaptiveBit open_near_[8][12][5], open_shape_[11][12], open_chroma_[12][12], open_slope_[12][11],
      open_history_[16][12];
  Mixer open_mixer_[8];
  ComponentStates components_[4];
  u32 history_ = 0;
};

/// Which base face lies in which region (5.4).
std::vector<u32> regions_of_faces(const Mesh& base, u32 region_count) {
  std::vector<u32> nearest(base.faces.size(), 0), distance(base.faces.size(), kNone);
  for (u32 region = 0; region < region_count; ++region) {
    const auto farthest = std::max_element(distance.begin(), distance.end());
    const u32 seed = static_cast<u32>(farthest - distance.begin());
    std::vector<u32> steps(base.faces.size(), kNone), reached = {seed};
    steps[seed] = 0;
    for (std::size_t i = 0; i < reached.size(); ++i) {
      for (const u32 edge : base.face_edges[reached[i]]) {
        const u32 beyond = base.face_beyond(edge, reached[i]);
        if (beyond == kNone || steps[beyond] != kNone) continue;
        steps[beyond] = steps[reached[i]] + 1;
        reached.push_back(beyond);
      }
    }
    for (const u32 face : reached) {
      if (steps[face] >= distance[face]) continue;
      distance[face] = steps[face];
      nearest[face] = region;
    }
  }
  return nearest;
}

/// One level of a region as a mesh of its own, with its numbers in the whole (5.4).
struct RegionMesh {
  Mesh mesh;
  std::vector<u32> edge_in_whole, face_in_whole;
  std::vector<bool> is_foreign;  // per edge
  std::vector<i64> inserted;     // per vertex

  /// Level 0.
  RegionMesh(const Mesh& base, const std::vector<u32>& region_of_face, u32 region) {
    std::map<u32, u32> edge_here, vertex_here, face_here;  // by their numbers in the whole
    for (u32 f = 0; f < base.faces.size(); ++f) {
      if (region_of_face[f] != region) continue;
      face_here[f] = static_cast<u32>(face_in_whole.size());
      face_in_whole.push_back(f);
      for (const u32 e : base.face_edges[f]) edge_here[e] = 0;
      for (const u32 v : base.faces[f]) vertex_here[v] = 0;
    }
    for (auto& [v, here] : vertex_here) here = mesh.vertex_count++;
    inserted.assign(mesh.vertex_count, 0);
    for (auto& [e, here] : edge_here) {
      here = static_cast<u32>(edge_in_whole.size());
      edge_in_whole.push_back(e);
      mesh.edges.push_back({vertex_here[base.edges[e][0]], vertex_here[base.edges[e][1]]});
      const auto face = [&](u32 f) { return face_here.contains(f) ? face_here[f] : kNone; };
      mesh.edge_faces.push_back({face(base.edge_faces[e][0]), face(base.edge_faces[e][1])});
      mesh.is_curve.push_back(base.is_curve[e]);
      is_foreign.push_back(mesh.edge_faces.back()[0] == kNone);
    }
    for (const u32 f : face_in_whole) {
      mesh.faces.push_back({});
      mesh.face_edges.push_back({});
      for (u32 k = 0; k < 3; ++k) {
        mesh.faces.back()[k] = vertex_here[base.faces[f][k]];
        mesh.face_edges.back()[k] = edge_here[base.face_edges[f][k]];
      }
    }
    mesh.find_curves();
  }

  /// The next finer level; `whole_edge_count` is that of this level.
  void refine(u32 whole_edge_count) {
    std::vector<u32> edges, faces;
    std::vector<bool> foreign;
    for (u32 e = 0; e < edge_in_whole.size(); ++e) {
      for (u32 half = 0; half < 2; ++half) {
        edges.push_back(2 * edge_in_whole[e] + half);
        foreign.push_back(is_foreign[e]);
      }
    }
    for (const u32 f : face_in_whole) {
      for (u32 k = 0; k < 3; ++k) {
        edges.push_back(2 * whole_edge_count + 3 * f + k);
        foreign.push_back(false);
      }
      for (u32 child = 0; child < 4; ++child) faces.push_back(4 * f + child);
    }
    mesh = split(mesh);
    edge_in_whole = edges;
    face_in_whole = faces;
    is_foreign = foreign;
  }
};

struct Stream {
  Header header;
  AttributeDecoder attributes[4];
  int base_layer = -1;
  BaseMeshDecoder base_decoder;
  GeometryDecoder geometry_decoder;
  std::vector<Mesh> meshes;  // by level
  std::vector<u8> is_crease;
  std::vector<i64> coordinates;
  std::vector<u32> valence;
  std::vector<Level> levels;
  std::vector<i64> inserted;  // per vertex of all levels decoded so far
  u64 value_count = 0;        // coefficients and attribute values of all layers
  std::vector<u32> region_of_face;
  std::vector<int> layer_of_region;

  const Mesh& mesh(int level) {
    while (static_cast<int>(meshes.size()) <= level) meshes.push_back(split(meshes.back()));
    return meshes[static_cast<std::size_t>(level)];
  }

  u64 vertices_of_level(int level) const {
    u64 v = header.vertex_count, e = meshes[0].edges.size(), f = header.face_count;
    for (int l = 0; l < level; ++l) {
      v += e;
      e = 2 * e + 3 * f;
      f *= 4;
    }
    return v;
  }
  /// Null, or the section of 8 that forbids the level after `bytes` bytes of the stream.
  const char* forbids(int level, u64 bytes, const Limits& limits) const {
    const u64 count = vertices_of_level(level);
    if (count > limits.vertices || count > (u64{1} << 30)) return "8";
    return level > 0 && count > 2048 + 64 * bytes ? "8.2" : nullptr;
  }

  /// 8.2: the values of all layers against the bytes.
  void count_values(u64 count, u64 bytes) {
    value_count += count;
    if (value_count > 32768 + 64 * bytes) fail(Code::kLimit, "8.2");
  }

  void decode_chunk(u8 type, const u8* payload, std::size_t size, u64 end_offset, const Limits& limits) {
    if (type == 1) {
      decode_base(payload, size);
    } else if (type == 2) {
      decode_correction(payload, size);
    } else if (type == 3) {
      decode_geometry(payload, size, end_offset, limits);
    } else if (type == 4) {
      decode_attribute(payload, size, end_offset, limits);
    } else if (type == 5) {
      decode_region(payload, size, end_offset, limits);
    } else if (type < 0x80) {
      fail(Code::kFeature, "3.2");
    }
  }

  void decode_base(const u8* payload, std::size_t size) {
    if (header.face_count > 1024 + 64 * u64{size}) fail(Code::kLimit, "8.2");
    ArithmeticDecoder code(payload, size);
    decode_part(code, [&] {
      check(base_layer < 0, "4.3");
      meshes.assign(1, {});
      base_decoder.decode_connectivity(code, header.vertex_count, header.face_count, meshes[0]);
      if (header.has_creases) is_crease = base_decoder.decode_creases(code, meshes[0]);
      meshes[0].find_curves();
      coordinates = base_decoder.decode_coordinates(code, meshes[0]);
    });
    valence.assign(header.vertex_count, 0);
    for (const auto& face : meshes[0].faces)
      for (const u32 v : face) ++valence[v];
    levels.resize(static_cast<std::size_t>(header.level_count));
    inserted.assign(header.vertex_count, 0);
    if (header.region_count > 0) region_of_face = regions_of_faces(meshes[0], header.region_count);
    layer_of_region.assign(header.region_count, -1);
    base_layer = 0;
  }

  void decode_correction(const u8* payload, std::size_t size) {
    check(size >= 1, "4.7");
    const int layer = payload[0];
    check(base_layer >= 0 && layer == base_layer + 1 && layer < header.layer_count, "4.3");
    ArithmeticDecoder code(payload + 1, size - 1);
    decode_part(code, [&] { base_decoder.correct(code, header.layer_ratio[layer], coordinates); });
    base_layer = layer;
  }

  void decode_geometry(const u8* payload, std::size_t size, u64 end_offset, const Limits& limits) {
    check(size >= 3, "5.3");
    const int layer = payload[0], first = payload[1], count = payload[2];
    check(count > 0 && first + count <= header.level_count, "5.3");
    check(base_layer >= 0, "4.3");
    ArithmeticDecoder code(payload + 3, size - 3);
    for (int l = first; l < first + count; ++l) {
      if (const char* section = forbids(l + 1, end_offset, limits)) fail(Code::kLimit, section);
      count_values(vertices_of_level(l + 1) - vertices_of_level(l), end_offset);
      decode_part(code, [&] {
        Level& level = levels[static_cast<std::size_t>(l)];
        check(layer < header.layer_count, "5.3");
        check(layer == level.layer + 1 && (l == 0 || levels[static_cast<std::size_t>(l) - 1].layer >= 0) &&
                  (header.region_count == 0 || l < header.region_level),
              "4.3");
        const Mesh& topology = mesh(l);
        const i64 ratio = layer > 0 ? header.layer_ratio[layer] : 1;
        geometry_decoder.decode_level(code, l, l > 0 ? &meshes[static_cast<std::size_t>(l) - 1] : nullptr,
                                      topology, inserted, ratio, level);
        level.layer = layer;
        inserted.resize(std::max(inserted.size(), topology.vertex_count + level.value.size()));
        std::copy(level.value.begin(), level.value.end(), inserted.begin() + topology.vertex_count);
      });
    }
  }

  void decode_region(const u8* payload, std::size_t size, u64 end_offset, const Limits& limits) {  // 5.4
    Reader reader{payload, size};
    const u64 place = reader.varint(), layer_count = static_cast<u64>(header.layer_count);
    check(!reader.is_past_end && !reader.is_misspelt && place / layer_count < header.region_count, "5.4");
    const int layer = static_cast<int>(place % layer_count);
    const u32 region = static_cast<u32>(place / layer_count);
    check(base_layer >= 0, "4.3");
    const int first = header.region_level, reached = levels[static_cast<std::size_t>(first)].layer;
    check(levels[static_cast<std::size_t>(first) - 1].layer >= 0 && layer == layer_of_region[region] + 1 &&
              (layer == reached || layer == reached + 1),
          "4.3");
    const auto decoder = std::make_unique<GeometryDecoder>(geometry_decoder);
    ArithmeticDecoder code(payload + reader.position, size - reader.position);
    RegionMesh part(meshes[0], region_of_face, region);
    for (int l = 0; l < first; ++l) {
      for (u32 e = 0; e < part.edge_in_whole.size(); ++e) {
        const i64 value = levels[static_cast<std::size_t>(l)].value[part.edge_in_whole[e]];
        part.inserted.push_back(part.is_foreign[e] ? 0 : value);
      }
      if (l + 1 < first) part.refine(static_cast<u32>(mesh(l).edges.size()));
    }
    for (int l = first; l < first + header.region_level_count; ++l) {
      if (const char* section = forbids(l + 1, end_offset, limits)) fail(Code::kLimit, section);
      const u32 whole_edge_count = static_cast<u32>(mesh(l - 1).edges.size());
      const Mesh coarse = part.mesh;
      decoder->is_foreign = part.is_foreign;
      part.refine(whole_edge_count);
      Level& whole = levels[static_cast<std::size_t>(l)];
      count_values(part.mesh.edges.size() + whole.tangential.size(), end_offset);
      decode_part(code, [&] {
        whole.value.resize(mesh(l).edges.size());
        if (whole.layer >= 0 && whole.layer < layer) bring_to_layer(whole, layer);
        whole.layer = layer;
        Level own;
        own.layer = layer - 1;
        own.value.resize(part.mesh.edges.size());
        for (u32 e = 0; e < part.mesh.edges.size(); ++e) {
          if (part.is_foreign[e]) continue;
          own.value[e] = whole.value[part.edge_in_whole[e]];
          const auto listed = whole.tangential.find(part.edge_in_whole[e]);
          if (listed != whole.tangential.end()) own.tangential[e] = listed->second;
        }
        decoder->decode_level(code, l, &coarse, part.mesh, part.inserted, 1, own);
        for (u32 e = 0; e < part.mesh.edges.size(); ++e) {
          if (part.is_foreign[e]) continue;
          whole.value[part.edge_in_whole[e]] = own.value[e];
          whole.tangential.erase(part.edge_in_whole[e]);
          if (own.tangential.contains(e)) whole.tangential[part.edge_in_whole[e]] = own.tangential[e];
        }
        part.inserted.insert(part.inserted.end(), own.value.begin(), own.value.end());
      });
    }
    layer_of_region[region] = layer;
  }

  void bring_to_layer(Level& level, int layer) const {
    const auto held = [&](i64 x) {
      return clamp(header.layer_ratio[layer] * x, -kLargestCoefficient, kLargestCoefficient);
    };
    for (i64& x : level.value) x = held(x);
    for (auto& [edge, t] : level.tangential) t = {held(t.along), held(t.across)};
  }

  void decode_attribute(const u8* payload, std::size_t size, u64 end_offset, const Limits& limits) {  // 10.3
    check(size >= 3, "10.3");
    const u32 index = payload[0];
    const int first = payload[1], count = payload[2];
    check(count > 0 && first + count <= header.level_count + 1, "10.3");
    check(base_layer >= 0, "10.3");
    ArithmeticDecoder code(payload + 3, size - 3);
    for (int l = first; l < first + count; ++l) {
      if (const char* section = forbids(l, end_offset, limits)) fail(Code::kLimit, section);
      if (index < header.attributes.size()) {
        const u64 added = vertices_of_level(l) - (l > 0 ? vertices_of_level(l - 1) : 0);
        count_values(added * static_cast<u64>(header.attributes[index].components), end_offset);
      }
      decode_part(code, [&] {
        check(index < header.attributes.size() && l <= header.attributes[index].finest_level, "10.3");
        AttributeDecoder& attribute = attributes[index];
        check(l == attribute.next_level, "10.3");
        if (l == 0)
          attribute.decode_level_0(code, header.attributes[index], meshes[0]);
        else
          attribute.decode_level(code, header.attributes[index], l, mesh(l - 1));
        attribute.next_level = l + 1;
      });
    }
  }

  /// 9.4; 0 where no values have come.
  u64 attribute_hash(u32 index, int level) {
    const AttributeTable& table = header.attributes[index];
    AttributeDecoder known = attributes[index];
    if (known.next_level == 0) return 0;
    for (int l = known.next_level; l <= level; ++l) {
      const Mesh& coarse = mesh(l - 1);
      known.values.resize(coarse.vertex_count);
      for (u32 e = 0; e < coarse.edges.size(); ++e) {
        std::array<i64, 4> predicted{};
        for (u32 c = 0; c < table.components; ++c) predicted[c] = known.interpolation(table, l, coarse, e, c);
        known.values.push_back(predicted);
      }
    }
    std::vector<u32> words;
    for (u64 v = 0; v < vertices_of_level(level); ++v)
      for (u32 c = 0; c < table.components; ++c) words.push_back(static_cast<u32>(known.values[v][c]));
    return hash_of(words);
  }

  // ---- 6.2 Prediction ----

  bool is_extraordinary(const Mesh& m, u32 v) const {
    return v < header.vertex_count && m.curves_at[v].empty() && valence[v] != 6;
  }

  /// The ring of an extraordinary vertex, from the other end of `edge` on (6.2.3).
  Vec3 ring(const Mesh& m, const std::vector<Vec3>& x, u32 v, u32 edge) const {
    const u32 n = valence[v];
    std::vector<double> s(n);
    double sum = 0;
    for (u32 i = 0; i < n; ++i) {
      constexpr double kOfThree[3] = {5.0 / 12, -1.0 / 12, -1.0 / 12}, kOfFour[4] = {0.375, 0, -0.125, 0};
      s[i] = n == 3   ? kOfThree[i]
             : n == 4 ? kOfFour[i]
                      : ((0.25 + cosine(i, n)) + 0.5 * cosine(2 * i, n)) / static_cast<double>(n);
      sum = sum + s[i];
    }
    Vec3 result = (1 - sum) * x[v];
    for (u32 i = 0; i < n; ++i) {
      const bool is_outward = m.edges[edge][0] == v;
      result = result + s[i] * x[m.edges[edge][is_outward ? 1 : 0]];
      // Counter-clockwise of a spoke lies the face that holds it directed outwards.
      const u32 face = m.edge_faces[edge][is_outward ? 0 : 1];
      u32 k = 0;
      while (m.faces[face][k] != v) ++k;
      edge = m.face_edges[face][(k + 1) % 3];
    }
    return result;
  }

  Vec3 correction(const Mesh& m, const std::vector<Vec3>& x, u32 edge) const {
    const auto [a, b] = m.edges[edge];
    if (m.is_curve[edge]) {  // 6.2.1
      const auto beyond = [&](u32 v) {
        const std::vector<u32>& curves = m.curves_at[v];
        if (curves.size() != 2) return kNone;
        const u32 other = curves[0] == edge ? curves[1] : curves[0];
        return m.edges[other][0] == v ? m.edges[other][1] : m.edges[other][0];
      };
      const u32 p = beyond(a), q = beyond(b);
      if (p != kNone && q != kNone) return 0.0625 * ((x[a] + x[b]) - (x[p] + x[q]));
      if (p == kNone && q == kNone) return {};
      const u32 c = p == kNone ? a : b, i = p == kNone ? b : a, n = p == kNone ? q : p;
      return 0.125 * (((x[i] + x[i]) - x[c]) - x[n]);
    }
    const bool of_a = is_extraordinary(m, a), of_b = is_extraordinary(m, b);
    if (of_a || of_b) {  // 6.2.3
      Vec3 rings;
      if (of_a) rings = rings + ring(m, x, a, edge);
      if (of_b) rings = rings + ring(m, x, b, edge);
      if (of_a && of_b) rings = 0.5 * rings;
      return rings - 0.5 * (x[a] + x[b]);
    }
    Vec3 tips, wings;  // 6.2.2
    for (const u32 face : m.edge_faces[edge]) {
      const u32 tip = m.third_corner(edge, face);
      tips = tips + x[tip];
      const auto wing = [&](u32 end, u32 other) {  // beyond the edge (end, tip)
        u32 k = 0;
        while (m.faces[face][k] != other) ++k;
        const u32 side = m.face_edges[face][k];
        return m.is_curve[side] ? (x[end] + x[tip]) - x[other]
                                : x[m.third_corner(side, m.face_beyond(side, face))];
      };
      const Vec3 beside_a = wing(a, b), beside_b = wing(b, a);
      wings = wings + (beside_a + beside_b);
    }
    return 0.0625 * ((tips + tips) - wings);
  }

  std::vector<Vec3> positions(int shown_level) {
    std::vector<Vec3> x;
    const i64 scale = header.ratio_after(base_layer);
    const auto on_grid = [&](std::size_t i) {
      return static_cast<double>(header.origin[i % 3] + scale * coordinates[i]) * header.grid_step;
    };
    for (std::size_t i = 0; i < coordinates.size(); i += 3)
      x.push_back({on_grid(i), on_grid(i + 1), on_grid(i + 2)});
    for (int l = 0; l < shown_level; ++l) {
      const Mesh& m = mesh(l);
      const Level& level = levels[static_cast<std::size_t>(l)];
      const double tension = header.tension_code[l] * 0.25;
      const double normal_step = step_of_code(header.grid_step, header.step_code[l]) *
                                 static_cast<double>(header.ratio_after(std::max(level.layer, 0)));
      const double tangential_step = step_of_code(normal_step, header.tangential_code);
      for (u32 e = 0; e < m.edges.size(); ++e) {
        const auto [a, b] = m.edges[e];
        Vec3 p = 0.5 * (x[a] + x[b]);
        if (tension != 0) p = p + tension * correction(m, x, e);  // 6.2.4
        const i64 c = level.layer < 0 ? 0 : level.value[e];
        const auto listed = level.tangential.find(e);
        const bool is_listed = listed != level.tangential.end();
        if (c != 0 || is_listed) {  // 6.3, 6.4
          const Vec3 direction = x[b] - x[a];
          const Vec3& tip = x[m.third_corner(e, m.edge_faces[e][0])];
          const Vec3& below = m.is_boundary(e) ? x[a] : x[m.third_corner(e, m.edge_faces[e][1])];
          const Vec3 normal = unit(cross(direction, tip - below), {0, 0, 1});
          p = p + (static_cast<double>(c) * normal_step) * normal;
          if (is_listed) {
            const Vec3 along = unit(direction, {1, 0, 0});
            p = p + (static_cast<double>(listed->second.along) * tangential_step) * along;
            p = p + (static_cast<double>(listed->second.across) * tangential_step) * cross(normal, along);
          }
        }
        x.push_back(p);
      }
    }
    return x;
  }

  // ---- 9 Conformance ----

  u64 state_hash() const {
    std::vector<u32> words = {header.vertex_count, header.face_count};
    for (const auto& face : meshes[0].faces) words.insert(words.end(), face.begin(), face.end());
    words.insert(words.end(), is_crease.begin(), is_crease.end());
    const auto add = [&](i64 x) { words.push_back(static_cast<u32>(x)); };
    for (const i64 x : coordinates) add(x);
    for (const Level& level : levels) {
      if (level.layer < 0) break;
      add(level.layer);
      for (const i64 c : level.value) add(c);
      for (const auto& [edge, t] : level.tangential) {
        add(edge);
        add(t.along);
        add(t.across);
      }
    }
    return hash_of(words);
  }

  Row row_at(u64 end_offset, u32 shown_level, const Limits& limits) {
    Row row{end_offset, shown_level, state_hash(), 0, 0, {}};
    const int level = static_cast<int>(shown_level);
    if (forbids(level, end_offset, limits)) {
      row.attribute_hashes.assign(header.attributes.size(), 0);
      return row;
    }
    std::vector<u32> words;
    for (const Vec3& p : positions(level)) {
      for (const double coordinate : {p.x, p.y, p.z}) {
        const double plus_zero = coordinate + 0.0;
        u64 bits;
        std::memcpy(&bits, &plus_zero, sizeof bits);
        words.push_back(static_cast<u32>(bits));
        words.push_back(static_cast<u32>(bits >> 32));
      }
    }
    row.position_hash = hash_of(words);
    words.clear();
    for (const auto& face : mesh(level).faces) words.insert(words.end(), face.begin(), face.end());
    row.index_hash = hash_of(words);
    for (u32 i = 0; i < header.attributes.size(); ++i)
      row.attribute_hashes.push_back(attribute_hash(i, level));
    return row;
  }
};

// ---- 3 Container ----

/// Thrown where the bytes end; not a Failure, since no rule is broken.
struct EndOfBytes {};

struct Chunk {
  u8 type;
  std::size_t payload, payload_size, end;  // offsets
};

/// The chunk at `offset`, in a row that ends at `row_end` (3.2).
Chunk read_chunk(const std::vector<u8>& bytes, u64 offset, u64 row_end, const Limits& limits) {
  Reader reader{bytes.data() + offset, bytes.size() - static_cast<std::size_t>(offset)};
  const u8 type = static_cast<u8>(reader.fixed(1));
  const u64 size = reader.varint();
  if (reader.is_past_end) throw EndOfBytes{};
  check(!reader.is_misspelt, "2.2");
  if (size > (1u << 30) || size > limits.chunk_size) fail(Code::kLimit, "8");
  const u64 payload = offset + reader.position, end = payload + size + 4;
  check(end <= row_end, "3.3.5");
  if (end > bytes.size()) throw EndOfBytes{};
  Reader stored{bytes.data() + payload + size, 4};
  if (stored.fixed(4) != crc32c(bytes.data() + offset, static_cast<std::size_t>(payload + size - offset)))
    fail(Code::kChecksum, "3.2");
  return {type, static_cast<std::size_t>(payload), static_cast<std::size_t>(size),
          static_cast<std::size_t>(end)};
}

/// The header, and in `end` where it ends (3.1, 3.3).
Header read_signature_and_header(const std::vector<u8>& bytes, u64& end) {
  constexpr u8 kSignature[4] = {0x8e, 0x4e, 0x4d, 0x43};
  for (std::size_t i = 0; i < 4 && i < bytes.size(); ++i)
    if (bytes[i] != kSignature[i]) fail(Code::kNotNmc, "3.1");
  if (bytes.size() < 5) throw EndOfBytes{};
  if (bytes[4] != 1) fail(Code::kVersion, "3.1");
  Reader reader{bytes.data() + 5, bytes.size() - 5};
  const u64 size = reader.varint();
  if (reader.is_past_end) throw EndOfBytes{};
  check(!reader.is_misspelt, "2.2");
  if (size > (1u << 16)) fail(Code::kLimit, "8");
  const std::size_t fields = 5 + reader.position, fields_end = fields + static_cast<std::size_t>(size);
  if (bytes.size() < fields_end + 4) throw EndOfBytes{};
  Reader stored{bytes.data() + fields_end, 4};
  if (stored.fixed(4) != crc32c(bytes.data(), fields_end)) fail(Code::kChecksum, "3.3");
  end = fields_end + 4;
  return read_header(bytes.data() + fields, static_cast<std::size_t>(size));
}

}  // namespace

Decoding decode(const std::vector<std::uint8_t>& bytes, const Limits& limits) {
  Decoding result;
  u64 at = 0;  // offset of the header or chunk at hand
  try {
    const auto stream = std::make_unique<Stream>();
    u64 row_begin = 0;
    stream->header = read_signature_and_header(bytes, row_begin);
    const Header& header = stream->header;
    if (header.vertex_count > limits.base_vertices || static_cast<u64>(header.level_count) > limits.levels ||
        header.vertex_count > limits.vertices) {
      fail(Code::kLimit, "8");
    }
    for (const LayerTableRow& row : header.rows) {
      const u64 row_end = row_begin + row.size;
      std::vector<Chunk> chunks;
      for (at = row_begin; at < row_end; at = chunks.back().end) {
        if (at > bytes.size()) throw EndOfBytes{};
        chunks.push_back(read_chunk(bytes, at, row_end, limits));
      }
      at = row_begin;
      for (const Chunk& chunk : chunks) {
        const u8* payload = bytes.data() + chunk.payload;
        Reader reader{payload, chunk.payload_size};
        const bool is_of_region =
            chunk.type == 5 && reader.varint() / static_cast<u64>(header.layer_count) + 1 == row.region;
        check(row.region == 0 || chunk.type >= 0x80 || is_of_region, "3.3.5");
        stream->decode_chunk(chunk.type, bytes.data() + chunk.payload, chunk.payload_size, chunk.end, limits);
        at = chunk.end;
      }
      at = row_begin;
      check(stream->base_layer >= 0, "4.3");
      result.rows.push_back(stream->row_at(row_end, row.level, limits));
      row_begin = at = row_end;
    }
    check(row_begin == bytes.size(), "3.2");
  } catch (const Failure& failure) {
    result.code = failure.code;
    result.section = failure.section;
    result.offset = at;
  } catch (const EndOfBytes&) {
    result.code = Code::kTruncated;
    result.section = "3.2";
    result.offset = bytes.size();
  }
  return result;
}

// ---- what the examples of the specification run ----

const char* name_of(Code code) {
  switch (code) {
    case Code::kOk:
      return "OK";
    case Code::kNotNmc:
      return "NOT_NMC";
    case Code::kVersion:
      return "VERSION";
    case Code::kFeature:
      return "FEATURE";
    case Code::kCorrupt:
      return "CORRUPT";
    case Code::kChecksum:
      return "CHECKSUM";
    case Code::kTruncated:
      return "TRUNCATED";
    case Code::kLimit:
      return "LIMIT";
  }
  return "";
}

std::uint32_t crc32c(const std::uint8_t* data, std::size_t size) {  // 2.3
  u32 sum = 0xffffffffu;
  for (std::size_t i = 0; i < size; ++i) {
    sum ^= data[i];
    for (int k = 0; k < 8; ++k) sum = sum & 1 ? sum >> 1 ^ 0x82f63b78u : sum >> 1;
  }
  return ~sum;
}

bool read_varint(const std::vector<std::uint8_t>& bytes, std::uint64_t& value) {
  Reader reader{bytes.data(), bytes.size()};
  value = reader.varint();
  return !reader.is_misspelt && !reader.is_past_end && reader.position == bytes.size();
}

std::vector<int> decisions(const std::vector<std::uint8_t>& payload,
                           const std::vector<std::uint32_t>& probabilities) {
  ArithmeticDecoder code(payload.data(), payload.size());
  std::vector<int> bits;
  for (const u32 p : probabilities) bits.push_back(code.decision(p));
  return bits;
}

std::uint64_t hash_of(const std::vector<std::uint32_t>& words) {  // 9.3
  u64 h = 0xcbf29ce484222325ull;
  for (const u32 word : words) h = (h ^ word) * 0x100000001b3ull;
  h ^= h >> 33;
  h *= 0xff51afd7ed558ccdull;
  h ^= h >> 33;
  h *= 0xc4ceb9fe1a85ec53ull;
  h ^= h >> 33;
  return h;
}

}  // namespace nmc_reference

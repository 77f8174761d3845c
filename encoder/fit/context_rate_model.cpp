// SPDX-License-Identifier: Apache-2.0
#include "encoder/fit/context_rate_model.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

namespace nmc {

namespace {

// Weights of the coder's mean magnitude in sixteenths, (2 near + 0.8 parents + 0.3 opposites) / 3.1 times 16:
// near is a mean of up to four edges, parents and opposites are means of two. Multiplied by 31, so that they
// are integers, and by 12, so that they remain so when divided by the number of near edges.
constexpr std::int32_t kNearTotal = 320 * 12;  // divided by the number of near edges (1, 2, 3, 4)
constexpr std::int32_t kParent = 64 * 12;
constexpr std::int32_t kOpposite = 24 * 12;
constexpr std::int32_t kWithNear = 31 * 12;
constexpr std::int32_t kWithoutNear = 11 * 12;

constexpr std::int64_t kBounds[10] = {1, 3, 6, 11, 18, 26, 40, 64, 128, 256};

constexpr float kSignBits = 0.85f;

}  // namespace

ContextRateModel::ContextRateModel(const SubdivisionHierarchy& hierarchy, int coded_level_count,
                                   const std::vector<std::int32_t>* previous, std::vector<std::int32_t> next,
                                   int ratio)
    : hierarchy_(hierarchy),
      level_count_(coded_level_count),
      previous_(previous),
      next_(std::move(next)),
      ratio_(ratio) {
  build_dependents();
  statistics_.resize(std::size_t{2} * static_cast<std::size_t>(level_count_) * kClasses);
  const CoefficientField zero(hierarchy_, level_count_);
  learn(zero);
}

void ContextRateModel::build_dependents() {
  const std::size_t vertex_count = hierarchy_.level(level_count_).vertex_count;
  level_of_.assign(vertex_count, 0);
  normalization_.assign(vertex_count, kWithoutNear);
  fixed_energy_.assign(vertex_count, 0);
  struct Link {
    std::uint32_t from, to;
    std::int32_t weight;
  };
  std::vector<Link> links;
  links.reserve(10 * vertex_count);
  for (int l = 0; l < level_count_; ++l) {
    const LevelTopology& t = hierarchy_.level(l);
    for (std::uint32_t e = 0; e < t.edge_count; ++e) {
      const std::uint32_t to = t.vertex_count + e;
      level_of_[to] = static_cast<std::uint8_t>(l + 1);
      std::uint32_t near[4];
      int near_count = 0;
      for (int side = 0; side < 2; ++side) {
        const std::uint32_t face = t.edge_faces[2 * e + side];
        if (face == kNone) continue;
        for (int k = 0; k < 3; ++k) {
          const std::uint32_t f = t.face_edges[3 * face + k];
          if (f != e && (f < e || previous_)) near[near_count++] = f;
        }
        const std::uint32_t opposite = t.opposite_vertex(e, face);
        if (opposite >= t.base_vertex_count) links.push_back({opposite, to, kOpposite});
      }
      for (int i = 0; i < near_count; ++i) {
        const std::int32_t weight = kNearTotal / near_count;
        if (near[i] < e)
          links.push_back({t.vertex_count + near[i], to, weight});
        else
          fixed_energy_[to] += contribution((*previous_)[t.vertex_count + near[i]], weight);
      }
      for (int i = 0; i < 2; ++i) {
        const std::uint32_t parent = t.edge_vertices[2 * e + i];
        if (parent >= t.base_vertex_count) links.push_back({parent, to, kParent});
      }
      if (l == 0) {
        normalization_[to] = 20 * 12;
      } else if (near_count) {
        normalization_[to] = kWithNear;
      }
    }
  }
  dependent_begin_.assign(vertex_count + 1, 0);
  for (const Link& link : links) ++dependent_begin_[link.from + 1];
  for (std::size_t v = 0; v < vertex_count; ++v) dependent_begin_[v + 1] += dependent_begin_[v];
  dependents_.resize(links.size());
  std::vector<std::size_t> next(dependent_begin_.begin(), dependent_begin_.end() - 1);
  for (const Link& link : links) dependents_[next[link.from]++] = {link.to, link.weight};
}

std::int64_t ContextRateModel::contribution(std::int32_t value, std::int32_t weight) const {
  return static_cast<std::int64_t>(std::abs(value)) * weight;
}

int ContextRateModel::context_of(std::size_t vertex, std::int64_t energy) const {
  const std::int64_t sixteenths = energy / normalization_[vertex];
  int k = 0;
  while (k < 10 && sixteenths >= kBounds[k]) ++k;
  const int layer = previous_ && (*previous_)[vertex] != 0 ? 1 : 0;
  return (layer * level_count_ + level_of_[vertex] - 1) * kClasses + k;
}

float ContextRateModel::cost_in(int context, std::size_t vertex, std::int32_t value) const {
  const std::int32_t coded = std::abs(previous_ ? value - (*previous_)[vertex] : value);
  const Statistics& s = statistics_[static_cast<std::size_t>(context)];
  if (coded < kMagnitudes - 1) return s.bits[static_cast<std::size_t>(coded)];
  return s.bits[kMagnitudes - 1] + 2 * std::log2(static_cast<float>(coded - kMagnitudes + 2)) + 1;
}

float ContextRateModel::cost_in_next(std::size_t vertex, std::int32_t value) const {
  if (next_.empty()) return 0;
  const std::int64_t correction = std::abs(next_[vertex] - std::int64_t{ratio_} * value);
  const Statistics& s = next_statistics_[2 * (level_of_[vertex] - std::size_t{1}) + (value != 0 ? 1 : 0)];
  if (correction < kMagnitudes - 1) return s.bits[static_cast<std::size_t>(correction)];
  return s.bits[kMagnitudes - 1] + 2 * std::log2(static_cast<float>(correction - kMagnitudes + 2)) + 1;
}

void ContextRateModel::learn_next() {
  if (next_.empty()) return;
  // A geometric law weighs as much as a handful of coefficients, until there are more of them.
  std::array<double, kMagnitudes> prior;
  double p = 4;
  for (double& c : prior) {
    c = p + 1e-3;
    p *= 0.4;
  }
  std::vector<std::array<double, kMagnitudes>> counts(2 * static_cast<std::size_t>(level_count_), prior);
  for (std::size_t v = 0; v < values_.size(); ++v) {
    if (level_of_[v] == 0) continue;
    const std::int64_t correction = std::abs(next_[v] - std::int64_t{ratio_} * values_[v]);
    counts[2 * (level_of_[v] - std::size_t{1}) + (values_[v] != 0 ? 1 : 0)]
          [static_cast<std::size_t>(std::min<std::int64_t>(correction, kMagnitudes - 1))] += 1;
  }
  next_statistics_.resize(counts.size());
  for (std::size_t i = 0; i < counts.size(); ++i) {
    double total = 0;
    for (const double c : counts[i]) total += c;
    for (std::size_t m = 0; m < kMagnitudes; ++m)
      next_statistics_[i].bits[m] =
          static_cast<float>(-std::log2(counts[i][m] / total)) + (m > 0 ? kSignBits : 0.0f);
  }
}

void ContextRateModel::learn(const CoefficientField& field) {
  values_ = field.values;
  learn_next();
  energy_ = fixed_energy_;
  for (std::size_t v = 0; v < values_.size(); ++v) {
    if (values_[v] == 0) continue;
    for (std::size_t i = dependent_begin_[v]; i < dependent_begin_[v + 1]; ++i)
      energy_[dependents_[i].vertex] += contribution(values_[v], dependents_[i].weight);
  }
  std::vector<std::array<double, kMagnitudes>> counts(statistics_.size());
  for (auto& c : counts) c.fill(0);
  for (std::size_t v = 0; v < values_.size(); ++v) {
    if (level_of_[v] == 0) continue;
    const std::int32_t coded = std::abs(previous_ ? values_[v] - (*previous_)[v] : values_[v]);
    counts[static_cast<std::size_t>(context_of(v, energy_[v]))]
          [static_cast<std::size_t>(std::min(coded, kMagnitudes - 1))] += 1;
  }
  // A class seldom seen leans on the same class of all levels, and that on a geometric law.
  const auto levels = static_cast<std::size_t>(level_count_);
  for (std::size_t layer = 0; layer < 2; ++layer) {
    for (std::size_t k = 0; k < kClasses; ++k) {
      std::array<double, kMagnitudes> pooled;
      const double mean = k == 0 ? 0.03 : 0.6 * static_cast<double>(kBounds[k - 1]) / 16 + 0.1;
      const double ratio = mean / (1 + mean);
      double p = 4 / (1 + mean), total = 0;
      for (double& c : pooled) {
        c = p + 1e-4;
        p *= ratio;
      }
      for (std::size_t l = 0; l < levels; ++l)
        for (std::size_t m = 0; m < kMagnitudes; ++m)
          pooled[m] += counts[(layer * levels + l) * kClasses + k][m];
      for (const double c : pooled) total += c;
      for (std::size_t l = 0; l < levels; ++l) {
        const std::size_t context = (layer * levels + l) * kClasses + k;
        constexpr double kPrior = 8;
        double sum = kPrior;
        for (const double c : counts[context]) sum += c;
        for (std::size_t m = 0; m < kMagnitudes; ++m) {
          const double share = (counts[context][m] + kPrior * pooled[m] / total) / sum;
          statistics_[context].bits[m] = static_cast<float>(-std::log2(share)) + (m > 0 ? kSignBits : 0.0f);
        }
      }
    }
  }
}

void ContextRateModel::costs(int level, std::size_t edge, const std::int32_t* candidates, int count,
                             double* bits) const {
  const std::size_t vertex = hierarchy_.level(level).vertex_count + edge;
  const int context = context_of(vertex, energy_[vertex]);
  for (int i = 0; i < count; ++i)
    bits[i] = cost_in(context, vertex, candidates[i]) + cost_in_next(vertex, candidates[i]);
  const std::int64_t present = std::abs(values_[vertex]);
  for (std::size_t d = dependent_begin_[vertex]; d < dependent_begin_[vertex + 1]; ++d) {
    const Dependent& dependent = dependents_[d];
    const std::int64_t others = energy_[dependent.vertex] - present * dependent.weight;
    for (int i = 0; i < count; ++i) {
      const int at = context_of(dependent.vertex, others + contribution(candidates[i], dependent.weight));
      bits[i] += cost_in(at, dependent.vertex, values_[dependent.vertex]);
    }
  }
}

std::int32_t ContextRateModel::resting_value(int level, std::size_t edge) const {
  return previous_ ? (*previous_)[hierarchy_.level(level).vertex_count + edge] : 0;
}

void ContextRateModel::set(int level, std::size_t edge, std::int32_t value) {
  const std::size_t vertex = hierarchy_.level(level).vertex_count + edge;
  const std::int64_t change = static_cast<std::int64_t>(std::abs(value)) - std::abs(values_[vertex]);
  values_[vertex] = value;
  if (change == 0) return;
  for (std::size_t d = dependent_begin_[vertex]; d < dependent_begin_[vertex + 1]; ++d)
    energy_[dependents_[d].vertex] += change * dependents_[d].weight;
}

double ContextRateModel::total_bits() const {
  double bits = 0;
  for (std::size_t v = 0; v < values_.size(); ++v)
    if (level_of_[v] != 0)
      bits += cost_in(context_of(v, energy_[v]), v, values_[v]) + cost_in_next(v, values_[v]);
  return bits;
}

}  // namespace nmc

// SPDX-License-Identifier: Apache-2.0
#include "encoder/curves/normal_curve.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "encoder/core/error.h"
#include "encoder/curves/curve_least_squares.h"

namespace nmc {

namespace {

std::size_t segment_count(std::size_t vertex_count, bool is_closed) {
  return vertex_count - (is_closed ? 0 : 1);
}

// Base vertices have no prediction; their normal lines bisect their segments.
std::vector<CurveFrame> base_frames(const std::vector<Vec3>& positions, bool is_closed, int dimension) {
  const std::size_t count = positions.size();
  std::vector<CurveFrame> frames(count);
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3& before = positions[i > 0 ? i - 1 : is_closed ? count - 1 : 0];
    const Vec3& after = positions[i + 1 < count ? i + 1 : is_closed ? 0 : i];
    frames[i] =
        curve_frame(normalized(after - positions[i], {}) + normalized(positions[i] - before, {}), dimension);
  }
  return frames;
}

void move_along_normals(NormalCurveLevel& level, const std::vector<std::array<double, 2>>& offsets) {
  for (std::size_t i = 0; i < level.positions.size(); ++i)
    level.positions[i] +=
        offsets[i][0] * level.frames[i].normal[0] + offsets[i][1] * level.frames[i].normal[1];
}

// The base along normal lines that pass through the reference, so that each vertex can still converge to its
// point R(u). A decoder knows the lines from the fitted base only, hence the fixed-point iteration.
void fit_base(const ReferenceCurve& reference, NormalCurveLevel& base, int dimension) {
  const std::vector<Vec3> anchors = base.positions;
  constexpr int kIterations = 40;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    base.positions = anchors;
    const CurveIntegrals integrals = integrate(reference, base, reference.is_closed());
    move_along_normals(base,
                       solve_along_normals(integrals, base.frames, dimension - 1, reference.is_closed()));
    base.frames = base_frames(base.positions, reference.is_closed(), dimension);
  }
}

// The crossing nearest to the middle of the parameter interval, inside the aperture.
std::optional<double> accepted_crossing(const std::vector<double>& crossings, double from, double to,
                                        double aperture) {
  const double middle = (from + to) / 2;
  double best_deviation = aperture * (to - from) / 2;
  std::optional<double> best;
  for (const double u : crossings) {
    const double deviation = std::abs(u - middle);
    if (deviation > best_deviation || u <= from || u >= to) continue;
    best_deviation = deviation;
    best = u;
  }
  return best;
}

// The level's connectivity, predictions, crossings and normal lines. Positions: even ones unchanged, odd ones
// on the reference.
NormalCurveLevel refine(const ReferenceCurve& reference, const NormalCurveLevel& coarse,
                        const NormalCurveOptions& options, std::vector<Vec3>& predictions) {
  const bool is_closed = reference.is_closed();
  const std::size_t count = coarse.positions.size(), segments = segment_count(count, is_closed);
  NormalCurveLevel level;
  level.positions.resize(count + segments);
  level.parameters.resize(count + segments);
  level.frames.resize(count + segments);
  level.details.resize(count + segments);
  level.is_normal.assign(count + segments, 1);
  predictions.assign(count + segments, Vec3{});
  for (std::size_t i = 0; i < count; ++i) {
    level.positions[2 * i] = predictions[2 * i] = coarse.positions[i];
    level.parameters[2 * i] = coarse.parameters[i];
    level.frames[2 * i] = coarse.frames[i];
    level.is_normal[2 * i] = coarse.is_normal[i];
  }
  std::vector<double> crossings;
  for (std::size_t i = 0; i < segments; ++i) {
    const std::size_t j = (i + 1) % count, odd = 2 * i + 1;
    const double from = coarse.parameters[i];
    const double to = j == 0 ? coarse.parameters[0] + 1 : coarse.parameters[j];
    const Vec3 predicted = predict_position(coarse.positions, i, is_closed, options.predictor);
    const CurveFrame frame = curve_frame(coarse.positions[j] - coarse.positions[i], options.dimension);
    reference.crossings(predicted, frame.tangent, from, to, crossings);
    const std::optional<double> crossing = accepted_crossing(crossings, from, to, options.aperture);
    const double u = crossing.value_or((from + to) / 2);
    predictions[odd] = predicted;
    level.frames[odd] = frame;
    level.parameters[odd] = u;
    level.positions[odd] = reference(u);
    if (!crossing) {
      level.is_normal[odd] = 0;
      ++level.non_normal_count;
    }
  }
  return level;
}

// Details are always the difference to the prediction in the vertex's own frame.
void record_details(NormalCurveLevel& level, const std::vector<Vec3>& predictions) {
  for (std::size_t i = 0; i < level.positions.size(); ++i) {
    const Vec3 difference = level.positions[i] - predictions[i];
    const CurveFrame& frame = level.frames[i];
    for (std::size_t k = 0; k < 2; ++k) level.details[i].normal[k] = dot(difference, frame.normal[k]);
    const bool is_new_vector = i % 2 == 1 && level.is_normal[i] == 0;
    level.details[i].tangential = is_new_vector ? dot(difference, frame.tangent) : 0;
  }
}

}  // namespace

NormalCurve build_normal_curve(const ReferenceCurve& reference, const std::vector<double>& base_parameters,
                               const NormalCurveOptions& options) {
  const bool is_closed = reference.is_closed();
  if (base_parameters.size() < (is_closed ? 3u : 2u))
    throw Error(ExitCode::kInvalidInput, "a normal curve needs a base of at least 2 vertices, closed 3");
  const int normal_count = options.dimension - 1;
  NormalCurve curve;
  curve.is_closed = is_closed;
  curve.options = options;

  NormalCurveLevel base;
  base.parameters = base_parameters;
  for (const double u : base_parameters) base.positions.push_back(reference(u));
  base.details.resize(base_parameters.size());
  base.is_normal.assign(base_parameters.size(), 1);
  base.frames = base_frames(base.positions, is_closed, options.dimension);
  if (options.fit == CurveFit::kVectorial) {
    const std::vector<Vec3> offsets = solve_vectorial(integrate(reference, base, is_closed), is_closed);
    for (std::size_t i = 0; i < offsets.size(); ++i) base.positions[i] += offsets[i];
  } else if (options.fit != CurveFit::kInterpolating) {
    fit_base(reference, base, options.dimension);
  }
  curve.levels.push_back(std::move(base));

  for (int l = 1; l <= options.level_count; ++l) {
    std::vector<Vec3> predictions;
    NormalCurveLevel level = refine(reference, curve.levels.back(), options, predictions);
    switch (options.fit) {
      case CurveFit::kInterpolating:
        break;
      case CurveFit::kVariational: {
        const CurveIntegrals integrals = integrate(reference, level, is_closed);
        move_along_normals(level, solve_along_normals(integrals, level.frames, normal_count, is_closed));
        break;
      }
      case CurveFit::kSombrero: {
        // The new vertices start at their predictions: the whole detail has to come from sombreros.
        for (std::size_t i = 1; i < level.positions.size(); i += 2)
          if (level.is_normal[i]) level.positions[i] = predictions[i];
        const CurveIntegrals integrals = integrate(reference, level, is_closed);
        const auto coefficients = solve_sombreros(integrals, level.frames, normal_count, is_closed);
        move_along_normals(level, apply_sombreros(coefficients, level.positions.size(), is_closed));
        break;
      }
      case CurveFit::kVectorial: {
        const std::vector<Vec3> offsets = solve_vectorial(integrate(reference, level, is_closed), is_closed);
        for (std::size_t i = 0; i < offsets.size(); ++i) level.positions[i] += offsets[i];
        break;
      }
    }
    record_details(level, predictions);
    curve.levels.push_back(std::move(level));
  }
  return curve;
}

std::vector<Vec3> reconstruct(const NormalCurve& curve) {
  std::vector<Vec3> positions = curve.levels.front().positions;
  std::vector<CurveFrame> frames = base_frames(positions, curve.is_closed, curve.options.dimension);
  for (std::size_t l = 1; l < curve.levels.size(); ++l) {
    const std::vector<CurveDetail>& details = curve.levels[l].details;
    const std::size_t count = positions.size(), segments = segment_count(count, curve.is_closed);
    std::vector<Vec3> finer(count + segments);
    std::vector<CurveFrame> finer_frames(count + segments);
    for (std::size_t i = 0; i < count; ++i) {
      finer[2 * i] = positions[i];
      finer_frames[2 * i] = frames[i];
    }
    for (std::size_t i = 0; i < segments; ++i) {
      finer[2 * i + 1] = predict_position(positions, i, curve.is_closed, curve.options.predictor);
      finer_frames[2 * i + 1] =
          curve_frame(positions[(i + 1) % count] - positions[i], curve.options.dimension);
    }
    for (std::size_t i = 0; i < finer.size(); ++i) {
      const CurveFrame& frame = finer_frames[i];
      finer[i] += details[i].normal[0] * frame.normal[0] + details[i].normal[1] * frame.normal[1] +
                  details[i].tangential * frame.tangent;
    }
    positions = std::move(finer);
    frames = std::move(finer_frames);
  }
  return positions;
}

double parametric_error(const ReferenceCurve& reference, const NormalCurveLevel& level, bool is_closed) {
  return std::sqrt(integrate(reference, level, is_closed).squared_error / reference.length());
}

double geometric_error(const ReferenceCurve& reference, const NormalCurveLevel& level, bool is_closed) {
  const auto mean_square = [](const ReferenceCurve& from, const ReferenceCurve& to) {
    constexpr std::size_t kLeastSamples = 4000;  // uniform in arc length
    const std::size_t count = std::max<std::size_t>(kLeastSamples, 2 * from.points().size());
    double sum = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const double d = to.distance_to(from((static_cast<double>(i) + 0.5) / static_cast<double>(count)));
      sum += d * d;
    }
    return sum / static_cast<double>(count);
  };
  const ReferenceCurve approximation(level.positions, is_closed);
  return std::sqrt(std::max(mean_square(approximation, reference), mean_square(reference, approximation)));
}

}  // namespace nmc

// SPDX-License-Identifier: Apache-2.0
// Chapters 2 and 3 on curves: Figs. 3.2 (rising frequency), 3.4 (coast line), 3.5 (Koch), 2.9 (space), 3.11
// and 3.12 (sombrero functions).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>

#include "bench/thesis/experiment.h"
#include "bench/thesis/svg_plot.h"
#include "encoder/core/error.h"
#include "encoder/curves/normal_curve.h"

namespace nmc_bench {

using namespace nmc;

namespace {

constexpr double kTau = 2 * std::numbers::pi;

struct Case {
  std::string name;
  ReferenceCurve reference;
  std::vector<double> base;
  NormalCurveOptions options;
};

std::vector<double> even_base(int count, bool is_closed, double shift = 0) {
  std::vector<double> base;
  const int segments = is_closed ? count : count - 1;
  for (int i = 0; i < count; ++i) base.push_back((i + shift) / segments);
  return base;
}

// Radius 1 + 0.05 sin(phase), with a frequency that rises along the circle.
ReferenceCurve rising_frequency() {
  std::vector<Vec3> points;
  constexpr int kCount = 12000;
  for (int i = 0; i < kCount; ++i) {
    const double s = static_cast<double>(i) / kCount;
    // The phase is a whole number of turns, and its speed grows from 0 to 240 turns per circle.
    const double phase = kTau * 120 * s * s;
    const double r = 1 + 0.05 * std::sin(phase);
    points.push_back({r * std::cos(kTau * s), r * std::sin(kTau * s), 0});
  }
  return {std::move(points), true};
}

ReferenceCurve koch_snowflake(int depth) {
  std::vector<Vec3> points;
  for (int k = 0; k < 3; ++k) points.push_back({std::cos(-kTau * k / 3), std::sin(-kTau * k / 3), 0});
  for (int level = 0; level < depth; ++level) {
    std::vector<Vec3> finer;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vec3 a = points[i], d = (points[(i + 1) % points.size()] - a) / 3;
      // Clockwise, so the tip is on the left.
      const Vec3 tip = a + d + Vec3{0.5 * d.x - std::sqrt(0.75) * d.y, std::sqrt(0.75) * d.x + 0.5 * d.y, 0};
      finer.insert(finer.end(), {a, a + d, tip, a + 2 * d});
    }
    points = std::move(finer);
  }
  return {std::move(points), true};
}

ReferenceCurve trefoil() {
  std::vector<Vec3> points;
  constexpr int kCount = 8000;
  for (int i = 0; i < kCount; ++i) {
    const double t = kTau * i / kCount, ripple = 0.04 * std::sin(60 * t);
    points.push_back({std::sin(t) + (2 + ripple) * std::sin(2 * t),
                      std::cos(t) - (2 + ripple) * std::cos(2 * t), -std::sin(3 * t) + ripple});
  }
  return {std::move(points), true};
}

// One "x y" per line.
ReferenceCurve read_polyline(const std::string& path, bool is_closed) {
  std::ifstream file(path);
  std::vector<Vec3> points;
  double x, y;
  while (file >> x >> y) points.push_back({x, y, 0});
  if (points.size() < 10) throw Error(ExitCode::kInputOutput, path + ": is not a coast line");
  return {std::move(points), is_closed};
}

NormalCurve build(const Case& c, CurveFit fit) {
  NormalCurveOptions options = c.options;
  options.fit = fit;
  return build_normal_curve(c.reference, c.base, options);
}

// Diagonal of the bounding box, which errors are relative to.
double diagonal(const ReferenceCurve& reference) {
  TriangleMesh mesh;
  mesh.positions = reference.points();
  return bounding_box(mesh).diagonal();
}

DrawnLine drawn(const NormalCurveLevel& level, bool is_closed, const std::string& color) {
  DrawnLine line{level.positions, is_closed, color, 1, {}};
  for (std::size_t i = 0; i < level.positions.size(); ++i) line.marks.push_back(level.is_normal[i] ? 0 : 2);
  return line;
}

void run_case(const Case& c, const std::string& figure, const Settings& settings,
              std::vector<int> drawn_levels, Table& table) {
  const NormalCurve inc = build(c, CurveFit::kInterpolating), vnc = build(c, CurveFit::kVariational);
  const NormalCurve vvc = build(c, CurveFit::kVectorial);
  const double size = diagonal(c.reference);
  Plot plot{figure + ": " + c.name, "vertices", "L2 error, % of the diagonal", true, true, {}};
  for (const auto& [name, curve] : {std::pair{"INC", &inc}, std::pair{"VNC", &vnc}, std::pair{"VVC", &vvc}}) {
    PlotSeries series{name, {}};
    for (const NormalCurveLevel& level : curve->levels)
      series.points.emplace_back(static_cast<double>(level.positions.size()),
                                 100 * geometric_error(c.reference, level, curve->is_closed) / size);
    plot.series.push_back(std::move(series));
  }
  for (std::size_t l = 0; l < inc.levels.size(); ++l) {
    const double a = plot.series[0].points[l].second, b = plot.series[1].points[l].second;
    table.add({c.name, fmt::format("{}", l), fmt::format("{}", inc.levels[l].positions.size()),
               fmt::format("{}", inc.levels[l].non_normal_count),
               fmt::format("{}", vnc.levels[l].non_normal_count), fmt::format("{:.4f}", a),
               fmt::format("{:.4f}", b), fmt::format("{:.4f}", plot.series[2].points[l].second),
               fmt::format("{:.2f}", a / b)});
  }
  std::vector<Drawing> drawings;
  for (const auto& [name, curve] : {std::pair{"INC", &inc}, std::pair{"VNC", &vnc}}) {
    for (const int l : drawn_levels) {
      const NormalCurveLevel& level = curve->levels[static_cast<std::size_t>(l)];
      Drawing drawing;
      drawing.title = fmt::format("{} level {}: {} vertices", name, l, level.positions.size());
      // The reference beneath, thinned to what a page can show.
      DrawnLine reference{{}, curve->is_closed, "#c9c9c9", 0.8, {}};
      const std::size_t stride = std::max<std::size_t>(1, c.reference.points().size() / 3000);
      for (std::size_t i = 0; i < c.reference.points().size(); i += stride)
        reference.points.push_back(c.reference.points()[i]);
      drawing.lines = {reference, drawn(level, curve->is_closed, "#1f4e79")};
      drawings.push_back(std::move(drawing));
    }
  }
  write_drawings(settings.output + "/" + figure + ".svg", drawings, static_cast<int>(drawn_levels.size()),
                 300);
  write_plots(settings.output + "/" + figure + "_error.svg", {plot});
}

double correlation(const std::vector<std::pair<double, double>>& pairs) {
  double mean_x = 0, mean_y = 0, xx = 0, yy = 0, xy = 0;
  const double count = static_cast<double>(pairs.size());
  for (const auto& [x, y] : pairs) {
    mean_x += x / count;
    mean_y += y / count;
  }
  for (const auto& [x, y] : pairs) {
    xx += (x - mean_x) * (x - mean_x);
    yy += (y - mean_y) * (y - mean_y);
    xy += (x - mean_x) * (y - mean_y);
  }
  return xy / std::sqrt(xx * yy);
}

// Section 3.7.1: refinement by sombreros, coarse to fine.
void run_lifting(const Case& c, const Settings& settings, Table& table) {
  const NormalCurve inc = build(c, CurveFit::kInterpolating), vnc = build(c, CurveFit::kVariational);
  const NormalCurve lifted = build(c, CurveFit::kSombrero);
  const double size = diagonal(c.reference);
  Plot errors{"Fig. 3.12: " + c.name, "level", "parametric L2 error, % of the diagonal", false, true, {}};
  for (const auto& [name, curve] :
       {std::pair{"INC", &inc}, std::pair{"VNC", &vnc}, std::pair{"sombreros", &lifted}}) {
    PlotSeries series{name, {}};
    for (std::size_t l = 0; l < curve->levels.size(); ++l)
      series.points.emplace_back(
          static_cast<double>(l),
          100 * parametric_error(c.reference, curve->levels[l], curve->is_closed) / size);
    errors.series.push_back(std::move(series));
  }
  // Details of new vertices: one level of sombreros on top of the variational curve's own coarser levels
  // would be the cleanest comparison; the thesis plots the coefficients of the two refinements as they are,
  // and so do we.
  Plot scatter{"coefficients, levels 1 to 3",
               "variational, % of the diagonal",
               "sombrero, % of the diagonal",
               false,
               false,
               {}};
  for (std::size_t l = 1; l <= 3; ++l) {
    PlotSeries series{fmt::format("level {}", l), {}, true};
    for (std::size_t i = 1; i < lifted.levels[l].details.size(); i += 2) {
      if (!lifted.levels[l].is_normal[i] || !vnc.levels[l].is_normal[i]) continue;
      series.points.emplace_back(100 * vnc.levels[l].details[i].normal[0] / size,
                                 100 * lifted.levels[l].details[i].normal[0] / size);
    }
    table.add({c.name, fmt::format("{}", l), fmt::format("{:.4f}", errors.series[0].points[l].second),
               fmt::format("{:.4f}", errors.series[1].points[l].second),
               fmt::format("{:.4f}", errors.series[2].points[l].second),
               fmt::format("{:.3f}", correlation(series.points))});
    scatter.series.push_back(std::move(series));
  }
  for (std::size_t l = 4; l < lifted.levels.size(); ++l)
    table.add({c.name, fmt::format("{}", l), fmt::format("{:.4f}", errors.series[0].points[l].second),
               fmt::format("{:.4f}", errors.series[1].points[l].second),
               fmt::format("{:.4f}", errors.series[2].points[l].second), "-"});
  write_plots(settings.output + "/fig_3_12_lifting_" + c.name + ".svg", {errors, scatter});
  std::vector<Drawing> drawings;
  for (const std::size_t l : {std::size_t{1}, std::size_t{2}, std::size_t{3}, std::size_t{4}}) {
    DrawnLine reference{{}, true, "#c9c9c9", 0.8, {}};
    const std::size_t stride = std::max<std::size_t>(1, c.reference.points().size() / 3000);
    for (std::size_t i = 0; i < c.reference.points().size(); i += stride)
      reference.points.push_back(c.reference.points()[i]);
    drawings.push_back({fmt::format("sombreros, level {}", l),
                        {reference, drawn(lifted.levels[l], lifted.is_closed, "#1f4e79")}});
  }
  write_drawings(settings.output + "/fig_3_11_lifting_" + c.name + ".svg", drawings, 4, 260);
}

}  // namespace

void run_curves(const Settings& settings) {
  Table table({"curve", "level", "vertices", "non-normal INC", "non-normal VNC", "INC %", "VNC %", "VVC %",
               "INC / VNC"});
  NormalCurveOptions options;
  options.level_count = 6;

  Case circle{"circle", rising_frequency(), even_base(8, true), options};
  circle.options.aperture = 0.9;
  run_case(circle, "fig_3_2_circle", settings, {2, 3, 4, 5}, table);

  Case aligned{"koch aligned", koch_snowflake(6), even_base(12, true), options};
  aligned.options.predictor = CurvePredictor::kMidpoint;
  aligned.options.level_count = 5;
  run_case(aligned, "fig_3_5_koch_aligned", settings, {1, 2, 3}, table);
  Case shifted{"koch misaligned", koch_snowflake(6), even_base(12, true, 0.37), aligned.options};
  run_case(shifted, "fig_3_5_koch_misaligned", settings, {1, 2, 3}, table);

  Case space{"trefoil in space", trefoil(), even_base(9, true), options};
  space.options.dimension = 3;
  run_case(space, "fig_2_9_space", settings, {1, 3, 5}, table);

  if (!settings.coast.empty()) {
    Case coast{"coast", read_polyline(settings.coast, true), even_base(32, true), options};
    coast.options.level_count = 6;
    run_case(coast, "fig_3_4_coast", settings, {1, 3, 5}, table);
  }
  table.print();
  table.write_csv(settings.output + "/curves.csv");

  Table lifting({"curve", "level", "INC %", "VNC %", "sombreros %", "correlation with VNC"});
  circle.options.aperture = 0.43;
  circle.options.level_count = 6;
  run_lifting(circle, settings, lifting);
  shifted.name = "koch";
  run_lifting(shifted, settings, lifting);
  lifting.print();
  lifting.write_csv(settings.output + "/lifting_curves.csv");
}

}  // namespace nmc_bench

// SPDX-License-Identifier: Apache-2.0
#include "bench/thesis/svg_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>

#include "encoder/core/error.h"

namespace nmc_bench {

namespace {

const char* const kColors[] = {"#1f77b4", "#d62728", "#2ca02c", "#9467bd",
                               "#ff7f0e", "#8c564b", "#17becf", "#7f7f7f"};

void save(const std::string& path, const std::string& body, double width, double height) {
  std::ofstream file(path);
  file << fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.0f} {1:.0f}\" width=\"{0:.0f}\" "
      "height=\"{1:.0f}\" "
      "font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
      width, height);
  file << body << "</svg>\n";
  if (!file.flush()) throw nmc::Error(nmc::ExitCode::kInputOutput, path + ": cannot be written");
}

// One axis of a plot: data to pixels, and where the ticks are.
class Axis {
 public:
  Axis(double low, double high, bool is_log, double from, double to)
      : is_log_(is_log), from_(from), to_(to), low_(value(low)), high_(value(high)) {
    if (!(high_ > low_)) high_ = low_ + 1;
  }
  double pixel(double x) const { return from_ + (value(x) - low_) / (high_ - low_) * (to_ - from_); }

  std::vector<double> ticks() const {
    std::vector<double> ticks;
    if (is_log_) {
      const int step = std::max(1, static_cast<int>(std::ceil((high_ - low_) / 8)));
      for (int e = static_cast<int>(std::ceil(low_ - 1e-9)); e <= high_ + 1e-9; e += step)
        ticks.push_back(std::pow(10.0, e));
      if (is_narrow()) {
        ticks.clear();
        for (int e = static_cast<int>(std::floor(low_)); e <= high_; ++e)
          for (const double digit : {1.0, 2.0, 5.0}) {
            const double tick = digit * std::pow(10.0, e);
            if (value(tick) >= low_ - 1e-9 && value(tick) <= high_ + 1e-9) ticks.push_back(tick);
          }
      }
      return ticks;
    }
    const double raw = (high_ - low_) / 5;
    const double magnitude = std::pow(10.0, std::floor(std::log10(raw)));
    const double step = raw / magnitude < 1.5   ? magnitude
                        : raw / magnitude < 3.5 ? 2 * magnitude
                        : raw / magnitude < 7.5 ? 5 * magnitude
                                                : 10 * magnitude;
    for (double t = std::ceil(low_ / step) * step; t <= high_ + 1e-9 * step; t += step)
      ticks.push_back(std::abs(t) < 1e-9 * step ? 0 : t);
    return ticks;
  }
  std::string label(double tick) const {
    return is_log_ && !is_narrow() ? fmt::format("1e{:.0f}", std::log10(tick)) : fmt::format("{:g}", tick);
  }

 private:
  /// Too few powers of ten to read anything from.
  bool is_narrow() const { return is_log_ && high_ - low_ < 2.6; }
  double value(double x) const { return is_log_ ? std::log10(x) : x; }
  bool is_log_;
  double from_, to_, low_, high_;
};

std::string escape(const std::string& text) {
  std::string result;
  for (const char c : text) result += c == '<' ? "&lt;" : c == '&' ? "&amp;" : std::string(1, c);
  return result;
}

constexpr double kWidth = 420, kHeight = 320, kMarginLeft = 64, kMarginTop = 30, kMarginBottom = 46;

std::string draw_plot(const Plot& plot, double left) {
  double low_x = std::numeric_limits<double>::infinity(), high_x = -low_x, low_y = low_x, high_y = -low_x;
  const auto shown = [&](const std::pair<double, double>& p) {
    return std::isfinite(p.first) && std::isfinite(p.second) && (!plot.log_x || p.first > 0) &&
           (!plot.log_y || p.second > 0);
  };
  for (const PlotSeries& s : plot.series)
    for (const auto& p : s.points) {
      if (!shown(p)) continue;
      low_x = std::min(low_x, p.first);
      high_x = std::max(high_x, p.first);
      low_y = std::min(low_y, p.second);
      high_y = std::max(high_y, p.second);
    }
  if (!(low_x <= high_x)) low_x = low_y = 1, high_x = high_y = 2;
  const double x0 = left + kMarginLeft, x1 = left + kWidth - 12, y0 = kHeight - kMarginBottom,
               y1 = kMarginTop;
  const Axis x(low_x, high_x, plot.log_x, x0, x1), y(low_y, high_y, plot.log_y, y0, y1);
  std::string body;
  const auto add = [&]<class... T>(fmt::format_string<T...> format, T&&... values) {
    body += fmt::format(format, std::forward<T>(values)...) + "\n";
  };
  add("<text x=\"{:.0f}\" y=\"18\" text-anchor=\"middle\" font-weight=\"bold\">{}</text>", (x0 + x1) / 2,
      escape(plot.title));
  for (const double t : x.ticks()) {
    add("<path d=\"M{0:.1f} {1:.1f}V{2:.1f}\" stroke=\"#e4e4e4\"/><text x=\"{0:.1f}\" y=\"{3:.1f}\" "
        "text-anchor=\"middle\">{4}</text>",
        x.pixel(t), y0, y1, y0 + 16, x.label(t));
  }
  for (const double t : y.ticks()) {
    add("<path d=\"M{0:.1f} {1:.1f}H{2:.1f}\" stroke=\"#e4e4e4\"/><text x=\"{3:.1f}\" y=\"{4:.1f}\" "
        "text-anchor=\"end\">{5}</text>",
        x0, y.pixel(t), x1, x0 - 6, y.pixel(t) + 4, y.label(t));
  }
  add("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"none\" stroke=\"#888\"/>",
      x0, y1, x1 - x0, y0 - y1);
  add("<text x=\"{:.0f}\" y=\"{:.0f}\" text-anchor=\"middle\">{}</text>", (x0 + x1) / 2, kHeight - 10.0,
      escape(plot.x_label));
  add("<text transform=\"translate({:.0f},{:.0f}) rotate(-90)\" text-anchor=\"middle\">{}</text>", left + 14,
      (y0 + y1) / 2, escape(plot.y_label));
  for (std::size_t i = 0; i < plot.series.size(); ++i) {
    const PlotSeries& s = plot.series[i];
    const char* color = kColors[i % std::size(kColors)];
    std::string path;
    std::size_t count = 0;
    for (const auto& p : s.points) {
      if (!shown(p)) continue;
      path += fmt::format("{}{:.1f} {:.1f}", count++ == 0 ? "M" : "L", x.pixel(p.first), y.pixel(p.second));
    }
    if (!s.dots_only) add("<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"1.6\"/>", path, color);
    if (s.dots_only || count <= 12)
      for (const auto& p : s.points)
        if (shown(p))
          add("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{}\" fill=\"{}\"/>", x.pixel(p.first),
              y.pixel(p.second), s.dots_only && count > 60 ? 1.3 : 2.6, color);
  }
  return body;
}

/// Beside the plot: inside it would lie on the lines of one figure or another.
std::string draw_legend(const Plot& plot, double left) {
  std::string body;
  for (std::size_t i = 0; i < plot.series.size(); ++i) {
    const double y = kMarginTop + 14 + 16 * static_cast<double>(i);
    body += fmt::format(
        "<path d=\"M{:.1f} {:.1f}h16\" stroke=\"{}\" stroke-width=\"3\"/><text x=\"{:.1f}\" "
        "y=\"{:.1f}\">{}</text>\n",
        left, y - 4, kColors[i % std::size(kColors)], left + 21, y, escape(plot.series[i].name));
  }
  return body;
}

double legend_width(const Plot& plot) {
  std::size_t longest = 0;
  for (const PlotSeries& s : plot.series) longest = std::max(longest, s.name.size());
  return 34 + 7.2 * static_cast<double>(longest);
}

bool same_series(const Plot& a, const Plot& b) {
  return std::equal(a.series.begin(), a.series.end(), b.series.begin(), b.series.end(),
                    [](const PlotSeries& s, const PlotSeries& t) { return s.name == t.name; });
}

}  // namespace

void write_plots(const std::string& path, const std::vector<Plot>& plots) {
  constexpr std::size_t kColumns = 2;
  std::string body;
  double left = 0, top = 0, width = 0;
  for (std::size_t i = 0; i < plots.size(); ++i) {
    body += fmt::format("<g transform=\"translate(0,{:.0f})\">\n", top) + draw_plot(plots[i], left);
    left += kWidth + 10;
    const bool ends_row = i % kColumns == kColumns - 1 || i + 1 == plots.size();
    if (ends_row || !same_series(plots[i], plots[i + 1])) {
      body += draw_legend(plots[i], left - 14);
      left += legend_width(plots[i]);
    }
    body += "</g>\n";
    width = std::max(width, left);
    if (!ends_row) continue;
    left = 0;
    top += kHeight + 10;
  }
  save(path, body, width, top);
}

void write_drawings(const std::string& path, const std::vector<Drawing>& drawings, int columns,
                    double panel_size) {
  double low[2] = {1e300, 1e300}, high[2] = {-1e300, -1e300};
  for (const Drawing& drawing : drawings)
    for (const DrawnLine& line : drawing.lines)
      for (const nmc::Vec3& p : line.points)
        for (int k = 0; k < 2; ++k) {
          low[k] = std::min(low[k], p[k]);
          high[k] = std::max(high[k], p[k]);
        }
  const double scale = (panel_size - 20) / std::max({high[0] - low[0], high[1] - low[1], 1e-300});
  const double panel_height = (high[1] - low[1]) * scale + 40;
  std::string body;
  for (std::size_t i = 0; i < drawings.size(); ++i) {
    const double left = panel_size * static_cast<double>(i % static_cast<std::size_t>(columns));
    const double top = panel_height * static_cast<double>(i / static_cast<std::size_t>(columns));
    body += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{}</text>\n",
                        left + panel_size / 2, top + 16, escape(drawings[i].title));
    for (const DrawnLine& line : drawings[i].lines) {
      std::string d;
      std::string marks;
      for (std::size_t k = 0; k < line.points.size(); ++k) {
        const double x = left + 10 + (line.points[k].x - low[0]) * scale;
        const double y = top + 28 + (high[1] - line.points[k].y) * scale;
        d += fmt::format("{}{:.1f} {:.1f}", k == 0 ? "M" : "L", x, y);
        if (k < line.marks.size() && line.marks[k])
          marks += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{}\" fill=\"{}\"/>", x, y,
                               line.marks[k] == 2 ? 2.4 : 1.4, line.marks[k] == 2 ? "#d62728" : "#1f4e79");
      }
      body += fmt::format("<path d=\"{}{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\"/>{}\n", d,
                          line.is_closed ? "Z" : "", line.color, line.width, marks);
    }
  }
  const double rows = std::ceil(static_cast<double>(drawings.size()) / columns);
  save(path, body, panel_size * columns, panel_height * rows);
}

}  // namespace nmc_bench

// SPDX-License-Identifier: Apache-2.0
// Line plots and polyline drawings as SVG, small enough for version control.
#ifndef NMC_BENCH_THESIS_SVG_PLOT_H_
#define NMC_BENCH_THESIS_SVG_PLOT_H_

#include <string>
#include <utility>
#include <vector>

#include "libnmc/common/vec3.h"

namespace nmc_bench {

struct PlotSeries {
  std::string name;
  std::vector<std::pair<double, double>> points;
  bool dots_only = false;
};

struct Plot {
  std::string title, x_label, y_label;
  bool log_x = false, log_y = false;
  std::vector<PlotSeries> series;
};

/// Plots in rows of two, each with its own axes; one legend for neighbours with the same series. Points that
/// a logarithmic axis cannot show are left out.
void write_plots(const std::string& path, const std::vector<Plot>& plots);

struct DrawnLine {
  std::vector<nmc::Vec3> points;  // x and y are drawn
  bool is_closed = false;
  std::string color = "#1f4e79";
  double width = 1;         // pixels
  std::vector<char> marks;  // per point: 0 none, 1 small dot, 2 red dot
};

struct Drawing {
  std::string title;
  std::vector<DrawnLine> lines;
};

/// Drawings in rows of `columns`, all with the same scale.
void write_drawings(const std::string& path, const std::vector<Drawing>& drawings, int columns,
                    double panel_size);

}  // namespace nmc_bench

#endif  // NMC_BENCH_THESIS_SVG_PLOT_H_

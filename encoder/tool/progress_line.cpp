// SPDX-License-Identifier: Apache-2.0
#include "encoder/tool/progress_line.h"

#include <fmt/core.h>

#include <cstdio>

namespace nmc {

void ProgressLine::show(std::string_view phase, double fraction) {
  if (!enabled_) return;
  const double now = watch_.seconds();
  const bool new_phase = phase != phase_;
  if (new_phase) {
    phase_ = phase;
    phase_begin_ = now;
  } else if (now - last_shown_ < 0.1) {
    return;  // a terminal over a slow line must not become the bottleneck
  }
  last_shown_ = now;
  fmt::print(stderr, "\r\x1b[K{}", phase);
  if (fraction > 0) fmt::print(stderr, " {:.0f} %", 100 * fraction);
  fmt::print(stderr, "  {:.0f} s", now);
  const double spent = now - phase_begin_;
  // Two seconds and a twentieth of the way: earlier estimates jump about.
  if (spent > 2 && fraction > 0.05)
    fmt::print(stderr, ", {:.0f} s left in this phase", spent * (1 / fraction - 1));
  std::fflush(stderr);
  shown_ = true;
}

void ProgressLine::clear() {
  if (shown_) fmt::print(stderr, "\r\x1b[K");
  shown_ = false;
}

}  // namespace nmc

// SPDX-License-Identifier: Apache-2.0
// One line on standard error that is rewritten in place while a person waits.
#ifndef NMC_ENCODER_TOOL_PROGRESS_LINE_H_
#define NMC_ENCODER_TOOL_PROGRESS_LINE_H_

#include <chrono>
#include <string>
#include <string_view>

namespace nmc {

/// Seconds since construction.
class Stopwatch {
 public:
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  }

 private:
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

/// Phase, percentage and an estimate of the time left in the phase. Silent unless enabled. Removes itself at
/// its end.
class ProgressLine {
 public:
  explicit ProgressLine(bool enabled) : enabled_(enabled) {}
  ~ProgressLine() { clear(); }
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  void show(std::string_view phase, double fraction);
  void clear();

 private:
  bool enabled_, shown_ = false;
  Stopwatch watch_;
  std::string phase_;
  double phase_begin_ = 0, last_shown_ = -1;
};

}  // namespace nmc

#endif  // NMC_ENCODER_TOOL_PROGRESS_LINE_H_

// SPDX-License-Identifier: Apache-2.0
#include "encoder/read/source.h"

#include <fmt/format.h>

#include <algorithm>

namespace nmc {

void Source::fail_at_line(const char* at, const std::string& reason, ExitCode code) const {
  const char* const stop = std::clamp(at, begin(), end());
  const auto line_feeds = std::count(begin(), stop, '\n');
  // Files with old Macintosh line ends have no line feed at all.
  const auto line =
      1 + (line_feeds > 0 || std::find(stop, end(), '\n') != end() ? line_feeds
                                                                   : std::count(begin(), stop, '\r'));
  throw Error(code, fmt::format("{}: line {}: {}", name, line, reason));
}

void Source::fail_at_byte(const char* at, const std::string& reason, ExitCode code) const {
  throw Error(code, fmt::format("{}: byte offset {}: {}", name, at - begin(), reason));
}

void Source::fail(const std::string& reason, ExitCode code) const {
  throw Error(code, fmt::format("{}: {}", name, reason));
}

}  // namespace nmc

// SPDX-License-Identifier: Apache-2.0
// The bytes a reader works on, with the name and the means to say where in them something is wrong.
#ifndef NMC_ENCODER_READ_SOURCE_H_
#define NMC_ENCODER_READ_SOURCE_H_

#include <cstddef>
#include <span>
#include <string>

#include "encoder/core/error.h"

namespace nmc {

struct Source {
  std::span<const std::byte> data;
  std::string name;    // for messages
  std::string folder;  // where files named inside the data are sought; empty: nowhere

  const char* begin() const { return reinterpret_cast<const char*>(data.data()); }
  const char* end() const { return begin() + data.size(); }

  /// Throws "name: line N: reason", N being the line of `at` counted from 1. O(bytes before `at`): lines are
  /// counted only when something is wrong, so that reading does not pay for it.
  [[noreturn]] void fail_at_line(const char* at, const std::string& reason,
                                 ExitCode code = ExitCode::kInvalidInput) const;

  /// Throws "name: byte offset N: reason".
  [[noreturn]] void fail_at_byte(const char* at, const std::string& reason,
                                 ExitCode code = ExitCode::kInvalidInput) const;

  /// Throws "name: reason", for faults that are not at one place.
  [[noreturn]] void fail(const std::string& reason, ExitCode code = ExitCode::kInvalidInput) const;
};

}  // namespace nmc

#endif  // NMC_ENCODER_READ_SOURCE_H_

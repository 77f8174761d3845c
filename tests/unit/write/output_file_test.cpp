// SPDX-License-Identifier: Apache-2.0
#include "decoder/write/output_file.h"

#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <csignal>
#include <filesystem>

namespace nmc {
namespace {

namespace fs = std::filesystem;

std::string temporary_path(const char* name) {
  return (fs::temp_directory_path() / ("nmc-output-test-" + std::to_string(::getpid()) + name)).string();
}

TEST_CASE("OutputFile: appears under its name only with commit", "[output]") {
  const std::string path = temporary_path("a");
  {
    OutputFile file(path);
    file.write("abc");
    CHECK(fs::exists(path + ".part"));
    CHECK_FALSE(fs::exists(path));
  }
  CHECK_FALSE(fs::exists(path + ".part"));
  CHECK_FALSE(fs::exists(path));
  {
    OutputFile file(path);
    file.write("abc");
    CHECK(file.commit());
  }
  CHECK(fs::file_size(path) == 3);
  CHECK_FALSE(fs::exists(path + ".part"));
  fs::remove(path);
}

TEST_CASE("OutputFile: a signal removes the part file before it ends the process", "[output]") {
  const std::string path = temporary_path("b");
  const pid_t child = ::fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    OutputFile::remove_part_file_on_signals();
    OutputFile file(path);
    file.write("abc");
    ::raise(SIGTERM);
    ::_exit(0);
  }
  int status = 0;
  REQUIRE(::waitpid(child, &status, 0) == child);
  CHECK(WIFSIGNALED(status));
  CHECK(WTERMSIG(status) == SIGTERM);
  CHECK_FALSE(fs::exists(path + ".part"));
  CHECK_FALSE(fs::exists(path));
}

}  // namespace
}  // namespace nmc

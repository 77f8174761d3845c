// SPDX-License-Identifier: Apache-2.0
// What main() of every tool of the decoder does.
#ifndef NMC_DECODER_TOOL_TOOL_MAIN_H_
#define NMC_DECODER_TOOL_TOOL_MAIN_H_

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <new>
#include <string>

#include "decoder/tool/tool_error.h"
#include "decoder/write/output_file.h"

namespace nmc {

/// "nmc-decode 0.1.0 (format 1)".
inline std::string version_line(const std::string& tool) {
  const unsigned version = nmc_version();
  return tool + " " + std::to_string(version / 10000) + "." + std::to_string(version / 100 % 100) + "." +
         std::to_string(version % 100) + " (format " + std::to_string(nmc_format_version()) + ")";
}

/// Parses the command line of `app`, runs `body` and turns every outcome into an exit code and one line on
/// standard error.
template <class Body>
int run_tool(CLI::App& app, int argc, char** argv, const Body& body) {
  const std::string tool = app.get_name();
  OutputFile::remove_part_file_on_signals();
  try {
    app.parse(argc, argv);
    return static_cast<int>(body());
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::Success)) return app.exit(error);
    std::fprintf(stderr, "%s: %s\nTry '%s --help'.\n", tool.c_str(), error.what(), tool.c_str());
    return static_cast<int>(ToolExit::kUsage);
  } catch (const ToolError& error) {
    std::fprintf(stderr, "%s: %s\n", tool.c_str(), error.what());
    return static_cast<int>(error.code());
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr, "%s: not enough memory\n", tool.c_str());
    return static_cast<int>(ToolExit::kLimit);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: internal error: %s\n", tool.c_str(), error.what());
    return static_cast<int>(ToolExit::kInternal);
  }
}

}  // namespace nmc

#endif  // NMC_DECODER_TOOL_TOOL_MAIN_H_

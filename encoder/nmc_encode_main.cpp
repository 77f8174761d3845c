// SPDX-License-Identifier: Apache-2.0
// nmc-encode: mesh files in, streams out. A thin front of encoder/tool/encode_file.h.
#include <fmt/core.h>
#include <oneapi/tbb/global_control.h>
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <exception>
#include <filesystem>
#include <map>
#include <new>
#include <optional>
#include <string>
#include <vector>

#include "decoder/write/output_file.h"
#include "encoder/core/error.h"
#include "encoder/tool/batch.h"
#include "encoder/tool/encode_arguments.h"
#include "encoder/tool/encode_file.h"
#include "encoder/tool/length_argument.h"

namespace {

using nmc::Error;
using nmc::ExitCode;

constexpr const char* kVersion = "nmc-encode 0.1.0 (format 1)";

/// Address space stands for memory: what the system refuses becomes std::bad_alloc, which ends in exit
/// code 6.
void limit_memory(const std::string& size) {
  const auto bytes = static_cast<rlim_t>(nmc::parse_size(size));
  const rlimit limit{bytes, bytes};
  if (setrlimit(RLIMIT_AS, &limit) != 0)
    throw Error(ExitCode::kUsage, "--memory-limit " + size + " was refused by the system");
}

ExitCode encode_or_report(const nmc::EncodeArguments& arguments, const std::string& input,
                          const std::string& output) {
  try {
    return nmc::encode_file(arguments, input, output);
  } catch (const Error& error) {
    fmt::print(stderr, "nmc-encode: {}\n", error.what());
    return error.code();
  } catch (const std::bad_alloc&) {
    fmt::print(stderr, "nmc-encode: {}: out of memory; nothing was written\n", input);
    return ExitCode::kLimit;
  } catch (const std::exception& error) {
    fmt::print(stderr, "nmc-encode: {}: internal error: {}\n", input, error.what());
    return ExitCode::kInternal;
  }
}

/// Two inputs of one name would overwrite each other's stream.
void check_distinct(const std::vector<std::string>& inputs, const std::vector<std::string>& outputs) {
  std::map<std::string, std::string> input_of;
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const auto [place, is_new] = input_of.emplace(outputs[i], inputs[i]);
    if (!is_new)
      throw Error(ExitCode::kUsage,
                  fmt::format("{} and {} would both become {}", place->second, inputs[i], outputs[i]));
  }
}

int run(const nmc::EncodeArguments& arguments) {
  std::vector<std::string> inputs = arguments.inputs;
  if (!arguments.batch.empty()) {
    const std::vector<std::string> listed = nmc::batch_inputs(arguments.batch);
    inputs.insert(inputs.end(), listed.begin(), listed.end());
  }
  if (inputs.empty()) throw Error(ExitCode::kUsage, "no INPUT; see --help");
  const bool one_file = inputs.size() == 1 && arguments.batch.empty();
  if (!one_file) {
    for (const auto& [name, value] :
         {std::pair{"-o", &arguments.output}, std::pair{"--report", &arguments.report},
          std::pair{"--emit-map", &arguments.vertex_map}, std::pair{"--glb", &arguments.glb}}) {
      if (!value->empty())
        throw Error(ExitCode::kUsage,
                    fmt::format("{} names one file, but there are several inputs; see --output-dir", name));
    }
  }
  if (!arguments.output_folder.empty()) std::filesystem::create_directories(arguments.output_folder);
  std::vector<std::string> outputs;
  for (const std::string& input : inputs) outputs.push_back(nmc::output_of(arguments, input));
  check_distinct(inputs, outputs);

  // The exit code of the first file that failed: a batch must not look fine when a part of it is missing.
  ExitCode first_failure = ExitCode::kOk;
  std::size_t failed = 0;
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const ExitCode code = encode_or_report(arguments, inputs[i], outputs[i]);
    if (code == ExitCode::kOk) continue;
    ++failed;
    if (first_failure == ExitCode::kOk) first_failure = code;
  }
  if (!one_file && !arguments.quiet)
    fmt::print(stderr, "{} of {} files encoded as asked\n", inputs.size() - failed, inputs.size());
  return static_cast<int>(first_failure);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "Compress a dense triangle surface. The result is a new, semi-regular mesh of the same shape; vertex "
      "order\n"
      "and connectivity of INPUT are not kept.");
  nmc::EncodeArguments arguments;
  nmc::declare_options(app, arguments);
  app.set_version_flag("-V,--version", kVersion);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : static_cast<int>(ExitCode::kUsage);
  }
  nmc::OutputFile::remove_part_file_on_signals();
  try {
    if (!arguments.memory_limit.empty()) limit_memory(arguments.memory_limit);
    std::optional<oneapi::tbb::global_control> limit;
    if (arguments.threads > 0) {
      limit.emplace(oneapi::tbb::global_control::max_allowed_parallelism, arguments.threads);
    }
    return run(arguments);
  } catch (const Error& error) {
    fmt::print(stderr, "nmc-encode: {}\n", error.what());
    return static_cast<int>(error.code());
  } catch (const std::exception& error) {
    fmt::print(stderr, "nmc-encode: {}\n", error.what());
    return static_cast<int>(ExitCode::kInputOutput);
  }
}

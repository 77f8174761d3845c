// SPDX-License-Identifier: Apache-2.0
// nmc-train-states: makes the tables with which the entropy coder starts (libnmc/common/trained_states.h).
//
//   nmc-train-states integers scan.nmc scan.integers      # what a stream holds, apart from how it is coded
//   nmc-train-states train *.integers -o libnmc/common/trained_states.cpp
//   nmc-train-states measure *.integers                   # bytes with untrained and with the present states
//
// States: every file is coded by models that know nothing; what their adaptive bits have counted is added up
// over files and over the levels that start alike. Weights of the mixers: from files coded with the states so
// found, the mean of where the weights end, in three rounds from where the last one ended.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <memory>

#include "bench/train/integers.h"
#include "encoder/core/error.h"

namespace {

using nmc::AdaptiveBit;
using nmc::BaseMeshModel;
using nmc::CoefficientModel;
using nmc::MixerWeights;
using nmc::TrainedMixer;
using nmc::bench::CodableMesh;

/// Fewer decisions than these say nothing: the state starts untrained.
constexpr double kLeastDecisions = 80;
constexpr int kWeightRounds = 3;

struct Tally {
  double decisions = 0, ones = 0;
};

/// What the states of all files have counted, in the order of the table.
class StateTallies {
 public:
  void begin_file() { next_ = 0; }
  void operator()(const AdaptiveBit* states, int states_per_level, int level_count, int told_apart) {
    if (tallies_.size() < next_ + static_cast<std::size_t>(states_per_level * told_apart))
      tallies_.resize(next_ + static_cast<std::size_t>(states_per_level * told_apart));
    for (int level = 0; level < level_count; ++level) {
      for (int i = 0; i < states_per_level; ++i) {
        const AdaptiveBit& bit = states[level * states_per_level + i];
        Tally& tally = tallies_[next_ + static_cast<std::size_t>(
                                            std::min(level, told_apart - 1) * states_per_level + i)];
        tally.decisions += bit.count();
        tally.ones += bit.count() * (bit.probability_16() / 65536.0);
      }
    }
    next_ += static_cast<std::size_t>(states_per_level * told_apart);
  }
  std::string letters() const {
    std::string text;
    int untrained = 0;
    const auto end_gap = [&] {
      if (untrained > 0) text += std::to_string(untrained);
      untrained = 0;
    };
    for (const Tally& tally : tallies_) {
      if (tally.decisions < kLeastDecisions) {
        ++untrained;
        continue;
      }
      end_gap();
      const double logit = std::log((tally.ones + 0.4) / (tally.decisions - tally.ones + 0.4));
      const auto letter = static_cast<int>(std::lround(logit * 256 / nmc::kLetterScale));
      text += nmc::kTrainedAlphabet[nmc::kLargestLetter +
                                    std::clamp(letter, -nmc::kLargestLetter, nmc::kLargestLetter)];
    }
    end_gap();
    return text;
  }

 private:
  std::vector<Tally> tallies_;
  std::size_t next_ = 0;
};

struct Models {
  BaseMeshModel base;
  CoefficientModel coefficients;
};

using Weights = std::array<std::array<double, nmc::kMaximumMixerInputs>, nmc::kTrainedMixerCount>;

template <class Visit>
void visit_mixers(Models& models, Visit&& visit) {
  models.base.visit_trained_mixers(visit);
  models.coefficients.visit_trained_mixers(visit);
}

Weights train_weights(const std::vector<CodableMesh>& meshes, const std::string& base_letters,
                      const std::string& coefficient_letters) {
  Weights weights{};
  for (int round = 0; round < kWeightRounds; ++round) {
    Weights sum{};
    std::array<double, nmc::kTrainedMixerCount> total{};
    for (const CodableMesh& mesh : meshes) {
      const auto models = std::make_unique<Models>();
      models->base.reset_untrained();
      models->coefficients.reset_untrained();
      models->base.visit_trained_states(nmc::TrainedStateReader(base_letters.c_str()));
      models->coefficients.visit_trained_states(nmc::TrainedStateReader(coefficient_letters.c_str()));
      visit_mixers(*models, [&](TrainedMixer row, int input_count, MixerWeights& mixer) {
        if (round == 0) return;
        for (int i = 0; i <= input_count; ++i) mixer.weight[i] = static_cast<std::int32_t>(weights[row][i]);
        mixer.rate = nmc::kTrainedRate;
      });
      mesh.code(models->base, models->coefficients);
      // A mixer counts by how far its rate has fallen: by how much it was used.
      visit_mixers(*models, [&](TrainedMixer row, int input_count, MixerWeights& mixer) {
        const double use = (round == 0 ? 800 : nmc::kTrainedRate) - mixer.rate;
        total[row] += use;
        for (int i = 0; i <= input_count; ++i) sum[row][i] += use * mixer.weight[i];
      });
    }
    for (int row = 0; row < nmc::kTrainedMixerCount; ++row)
      for (double& w : sum[static_cast<std::size_t>(row)]) w /= total[static_cast<std::size_t>(row)];
    weights = sum;
  }
  return weights;
}

std::string string_literal(const std::string& name, const std::string& letters) {
  std::string text = "const char " + name + "[] =\n";
  constexpr std::size_t kPerLine = 104;
  for (std::size_t at = 0; at < letters.size(); at += kPerLine) {
    text += "    \"" + letters.substr(at, kPerLine) + "\"" + (at + kPerLine < letters.size() ? "\n" : ";\n");
  }
  return text;
}

void train(const std::vector<CodableMesh>& meshes, const std::string& output) {
  StateTallies base, coefficients;
  for (const CodableMesh& mesh : meshes) {
    const auto models = std::make_unique<Models>();
    models->base.reset_untrained();
    models->coefficients.reset_untrained();
    mesh.code(models->base, models->coefficients);
    base.begin_file();
    coefficients.begin_file();
    models->base.visit_trained_states(base);
    models->coefficients.visit_trained_states(coefficients);
  }
  const Weights weights = train_weights(meshes, base.letters(), coefficients.letters());
  std::ofstream file(output);
  file << "// SPDX-License-Identifier: Apache-2.0\n// Made by nmc-train-states (bench/train): not to be "
          "edited.\n"
          "#include \"libnmc/common/trained_states.h\"\n\nnamespace nmc {\n\n// clang-format off\n"
       << string_literal("kTrainedBaseStates", base.letters()) << "\n"
       << string_literal("kTrainedCoefficientStates", coefficients.letters())
       << "\nconst std::int8_t kTrainedWeights[kTrainedMixerCount][kMaximumMixerInputs] = {\n";
  for (const auto& row : weights) {
    file << "    {";
    for (std::size_t i = 0; i < row.size(); ++i)
      file << (i ? ", " : "") << std::clamp<long>(std::lround(row[i] / 512), -127, 127);
    file << "},\n";
  }
  file << "};\n// clang-format on\n\n}  // namespace nmc\n";
  if (!file) throw nmc::Error(nmc::ExitCode::kInputOutput, output + ": cannot be written");
  fmt::print("{}: {} files, {} + {} letters\n", output, meshes.size(), base.letters().size(),
             coefficients.letters().size());
}

void measure(const std::vector<CodableMesh>& meshes) {
  fmt::print("{:<32} {:>10} {:>10} {:>14} {:>10} {:>8}\n", "file", "base", "trained", "coefficients",
             "trained", "change");
  double log_ratio = 0;
  for (const CodableMesh& mesh : meshes) {
    const auto untrained = std::make_unique<Models>(), trained = std::make_unique<Models>();
    untrained->base.reset_untrained();
    untrained->coefficients.reset_untrained();
    const CodableMesh::Bits before = mesh.code(untrained->base, untrained->coefficients);
    const CodableMesh::Bits after = mesh.code(trained->base, trained->coefficients);
    const double ratio = (after.base + after.coefficients) / (before.base + before.coefficients);
    log_ratio += std::log(ratio);
    fmt::print("{:<32} {:>8.0f} B {:>8.0f} B {:>12.0f} B {:>8.0f} B {:>6.2f} %\n", mesh.name(),
               before.base / 8, after.base / 8, before.coefficients / 8, after.coefficients / 8,
               100 * (ratio - 1));
  }
  fmt::print("geometric mean: {:.2f} %\n",
             100 * (std::exp(log_ratio / static_cast<double>(meshes.size())) - 1));
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Trains the states with which the entropy coder starts.");
  app.require_subcommand(1);
  std::string stream, output;
  std::vector<std::string> inputs;
  CLI::App* integers =
      app.add_subcommand("integers", "writes what a stream holds, apart from how it is coded");
  integers->add_option("stream", stream, "a .nmc file")->required();
  integers->add_option("output", output, "the file to write")->required();
  CLI::App* training = app.add_subcommand("train", "makes the table from files of integers");
  training->add_option("inputs", inputs, "files of integers")->required();
  training->add_option("-o,--output", output, "the source file to write")->required();
  CLI::App* measuring = app.add_subcommand("measure", "bytes of files of integers, untrained and trained");
  measuring->add_option("inputs", inputs, "files of integers")->required();
  CLI11_PARSE(app, argc, argv);
  try {
    if (integers->parsed()) {
      write_integers(nmc::bench::integers_of_stream(stream), output);
      return 0;
    }
    std::vector<CodableMesh> meshes;
    meshes.reserve(inputs.size());
    for (const std::string& input : inputs) meshes.emplace_back(nmc::bench::read_integers(input));
    if (training->parsed())
      train(meshes, output);
    else
      measure(meshes);
  } catch (const nmc::Error& error) {
    fmt::print(stderr, "nmc-train-states: {}\n", error.what());
    return static_cast<int>(error.code());
  }
  return 0;
}

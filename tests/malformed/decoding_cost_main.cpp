// SPDX-License-Identifier: Apache-2.0
// What files cost a decoder, whatever they hold: processor time for each byte beyond the time that an empty
// decoder takes, and memory. For files made by fuzzers, against the streams that are typical. Usage:
// decoding_cost TYPICAL_FOLDER FOLDER... Fails when a file takes over 50 times the typical time per byte
// (files below 100 bytes count as 100), or one of at most 100 bytes more than a mebibyte.
#include <algorithm>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "libnmc/include/nmc/nmc.h"

namespace {

constexpr std::size_t kGrantedBytes = 512;

struct Cost {
  std::string path;
  std::size_t size = 0;
  double seconds = 0, seconds_per_byte = 0;
  std::uint64_t peak = 0;  // beyond the decoder itself
};

double processor_seconds() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// All that a program does with a file: decodes it, reads positions and indices of the last level.
double decode_once(const std::vector<unsigned char>& bytes, std::uint64_t& peak) {
  const double start = processor_seconds();
  nmc_decoder* decoder = nullptr;
  if (nmc_decoder_create(&decoder, nullptr, nullptr) != NMC_OK) return 0;
  nmc_decoder_feed(decoder, bytes.data(), bytes.size());
  nmc_event event = NMC_EVENT_HEADER;
  while (nmc_decoder_next(decoder, &event) == NMC_OK) {
  }
  nmc_layer layer;
  std::uint32_t vertex_count = 0, face_count = 0;
  if (nmc_decoder_current_layer(decoder, &layer) == NMC_OK &&
      nmc_decoder_mesh_size(decoder, layer.level, &vertex_count, &face_count) == NMC_OK) {
    std::vector<float> positions(std::size_t{3} * vertex_count);
    std::vector<std::uint32_t> indices(std::size_t{3} * face_count);
    nmc_decoder_read_positions(decoder, layer.level, positions.data(), 12, vertex_count);
    nmc_decoder_read_indices(decoder, layer.level, indices.data(), indices.size());
  }
  std::uint64_t used = 0;
  nmc_decoder_memory(decoder, &used, &peak);
  nmc_decoder_destroy(&decoder);
  return processor_seconds() - start;
}

Cost cost_of(const std::string& path, const std::vector<unsigned char>& bytes, std::size_t granted,
             const Cost& empty) {
  Cost cost{path, bytes.size(), 0, 0, 0};
  const double budget = processor_seconds() + 0.5;
  for (int run = 0; run < 5 && (run < 2 || processor_seconds() < budget); ++run) {
    const double seconds = decode_once(bytes, cost.peak);
    if (run == 0 || seconds < cost.seconds) cost.seconds = seconds;
  }
  cost.peak -= std::min(cost.peak, empty.peak);
  cost.seconds_per_byte =
      std::max(0.0, cost.seconds - empty.seconds) / static_cast<double>(granted + cost.size);
  return cost;
}

std::vector<Cost> costs_of(const std::string& folder, std::size_t granted, const Cost& empty) {
  std::vector<Cost> costs;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    std::ifstream file(entry.path(), std::ios::binary);
    const std::vector<unsigned char> bytes{std::istreambuf_iterator<char>(file), {}};
    costs.push_back(cost_of(entry.path().string(), bytes, granted, empty));
  }
  std::sort(costs.begin(), costs.end(),
            [](const Cost& a, const Cost& b) { return a.seconds_per_byte > b.seconds_per_byte; });
  return costs;
}

}  // namespace

int main(int argument_count, char** arguments) {
  if (argument_count < 3) return 2;
  const Cost empty = cost_of("", {}, 1, {});
  const std::vector<Cost> typical = costs_of(arguments[1], 0, empty);
  if (typical.empty()) return 2;
  const double usual = typical[typical.size() / 2].seconds_per_byte;
  std::printf("a decoder of nothing: %.1f us, %llu bytes\n", 1e6 * empty.seconds,
              static_cast<unsigned long long>(empty.peak));
  std::printf("%zu typical streams: %.3f us per byte (median), slowest %.3f\n", typical.size(), 1e6 * usual,
              1e6 * typical.front().seconds_per_byte);
  bool is_bounded = true;
  for (int i = 2; i < argument_count; ++i) {
    const std::vector<Cost> costs = costs_of(arguments[i], kGrantedBytes, empty);
    std::uint64_t largest_small = 0;
    for (const Cost& cost : costs)
      if (cost.size <= 100) largest_small = std::max(largest_small, cost.peak);
    std::printf("%s: %zu files, at most 100 bytes take up to %llu bytes; the slowest:\n", arguments[i],
                costs.size(), static_cast<unsigned long long>(largest_small));
    for (std::size_t k = 0; k < costs.size() && k < 5; ++k) {
      std::printf("  %9.3f us per byte, %6.1f times the typical: %7zu bytes, %9.1f us  %s\n",
                  1e6 * costs[k].seconds_per_byte, costs[k].seconds_per_byte / usual, costs[k].size,
                  1e6 * costs[k].seconds, costs[k].path.c_str());
    }
    is_bounded &=
        largest_small <= (1u << 20) && (costs.empty() || costs.front().seconds_per_byte <= 50 * usual);
  }
  std::printf("%s\n", is_bounded ? "within bounds" : "BEYOND the bounds");
  return is_bounded ? 0 : 1;
}

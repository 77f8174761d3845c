// SPDX-License-Identifier: Apache-2.0
// nmc.hpp: nmc.h for C++20. A StreamReader owns its nmc_decoder; nothing here that a C caller cannot do, no
// exceptions.
//
//   nmc::StreamReader reader;                              // check reader.status() once
//   reader.feed(bytes);
//   for (nmc_event event; reader.next(event) == NMC_OK;) {
//     if (event == NMC_EVENT_LAYER) show(reader);
//   }
#ifndef NMC_NMC_HPP_
#define NMC_NMC_HPP_

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "nmc.h"

namespace nmc {

/// A decoder of one stream at a time. Move-only; a moved-from reader may only be destroyed or assigned to.
/// Every function is the one of nmc.h with the same name and says no more than it does there.
class StreamReader {
 public:
  StreamReader() : StreamReader(nmc_default_limits()) {}
  explicit StreamReader(const nmc_limits& limits, const nmc_allocator* allocator = nullptr)
      : status_(nmc_decoder_create(&decoder_, &limits, allocator)) {}
  StreamReader(StreamReader&& other) noexcept
      : decoder_(std::exchange(other.decoder_, nullptr)),
        status_(std::exchange(other.status_, NMC_ERR_STATE)) {}
  StreamReader& operator=(StreamReader&& other) noexcept {
    std::swap(decoder_, other.decoder_);
    std::swap(status_, other.status_);
    return *this;
  }
  ~StreamReader() { nmc_decoder_destroy(&decoder_); }

  /// Of the creation. Unless it is NMC_OK all other functions return NMC_ERR_ARGUMENT.
  [[nodiscard]] nmc_status status() const { return status_; }
  nmc_decoder* get() const { return decoder_; }

  [[nodiscard]] nmc_status reset() { return nmc_decoder_reset(decoder_); }
  [[nodiscard]] nmc_status feed(std::span<const std::byte> bytes) {
    return nmc_decoder_feed(decoder_, bytes.data(), bytes.size());
  }
  [[nodiscard]] nmc_status feed(std::span<const std::uint8_t> bytes) {
    return nmc_decoder_feed(decoder_, bytes.data(), bytes.size());
  }
  [[nodiscard]] nmc_status next(nmc_event& event) { return nmc_decoder_next(decoder_, &event); }
  [[nodiscard]] nmc_status finish() { return nmc_decoder_finish(decoder_); }
  nmc_error_detail error() const {
    nmc_error_detail detail = {status_, 0, 0, "", ""};
    nmc_decoder_error(decoder_, &detail);
    return detail;
  }

  [[nodiscard]] nmc_status info(nmc_info& info) const { return nmc_decoder_info(decoder_, &info); }
  [[nodiscard]] nmc_status layer(std::uint32_t index, nmc_layer& layer) const {
    return nmc_decoder_layer(decoder_, index, &layer);
  }
  [[nodiscard]] nmc_status current_layer(nmc_layer& layer) const {
    return nmc_decoder_current_layer(decoder_, &layer);
  }
  [[nodiscard]] nmc_status set_threads(nmc_run_tasks run_tasks, void* user) {
    return nmc_decoder_set_threads(decoder_, run_tasks, user);
  }
  [[nodiscard]] nmc_status skip_layer() { return nmc_decoder_skip_layer(decoder_); }
  [[nodiscard]] nmc_status read_regions(std::span<std::uint8_t> regions) {
    return nmc_decoder_read_regions(decoder_, regions.data(), static_cast<std::uint32_t>(regions.size()));
  }
  [[nodiscard]] nmc_status select_layer(nmc_criterion criterion, double value, std::uint32_t& index,
                                        bool* is_met = nullptr) const {
    int met = 0;
    const nmc_status status = nmc_decoder_select_layer(decoder_, criterion, value, &index, &met);
    if (is_met) *is_met = met != 0;
    return status;
  }

  [[nodiscard]] nmc_status mesh_size(std::uint32_t level, std::uint32_t& vertex_count,
                                     std::uint32_t& face_count) const {
    return nmc_decoder_mesh_size(decoder_, level, &vertex_count, &face_count);
  }
  [[nodiscard]] nmc_status read_indices(std::uint32_t level, std::span<std::uint32_t> indices) {
    return nmc_decoder_read_indices(decoder_, level, indices.data(), indices.size());
  }
  /// Tightly packed: three values per vertex.
  [[nodiscard]] nmc_status read_positions(std::uint32_t level, std::span<float> xyz) {
    return nmc_decoder_read_positions(decoder_, level, xyz.data(), 3 * sizeof(float),
                                      vertex_count_of(xyz.size()));
  }
  [[nodiscard]] nmc_status read_positions(std::uint32_t level, std::span<double> xyz) {
    return nmc_decoder_read_positions_double(decoder_, level, xyz.data(), 3 * sizeof(double),
                                             vertex_count_of(xyz.size()));
  }
  [[nodiscard]] nmc_status read_normals(std::uint32_t level, std::span<float> xyz) {
    return nmc_decoder_read_normals(decoder_, level, xyz.data(), 3 * sizeof(float),
                                    vertex_count_of(xyz.size()));
  }
  [[nodiscard]] nmc_status attribute(std::uint32_t index, nmc_attribute& attribute) const {
    return nmc_decoder_attribute(decoder_, index, &attribute);
  }
  /// Tightly packed: red, green, blue per vertex.
  [[nodiscard]] nmc_status read_colors(std::uint32_t level, std::span<std::uint8_t> rgb) {
    return nmc_decoder_read_colors(decoder_, level, rgb.data(), 3, 3, vertex_count_of(rgb.size()));
  }
  [[nodiscard]] nmc_status attribute_hash(std::uint32_t index, std::uint32_t level, std::uint64_t& hash) {
    return nmc_decoder_attribute_hash(decoder_, index, level, &hash);
  }
  [[nodiscard]] nmc_status state_hash(std::uint64_t& hash) const {
    return nmc_decoder_state_hash(decoder_, &hash);
  }
  [[nodiscard]] nmc_status position_hash(std::uint32_t level, std::uint64_t& hash) {
    return nmc_decoder_position_hash(decoder_, level, &hash);
  }
  [[nodiscard]] nmc_status memory(std::uint64_t& used, std::uint64_t& peak) const {
    return nmc_decoder_memory(decoder_, &used, &peak);
  }

 private:
  /// Sizes that are no multiple of three, or too large, match no level.
  static std::uint32_t vertex_count_of(std::size_t value_count) {
    return value_count % 3 == 0 && value_count / 3 < 0xffffffffu ? static_cast<std::uint32_t>(value_count / 3)
                                                                 : 0xffffffffu;
  }

  nmc_decoder* decoder_ = nullptr;
  nmc_status status_;
};

}  // namespace nmc

#endif  // NMC_NMC_HPP_

// SPDX-License-Identifier: Apache-2.0
// A priority queue of vertices with changeable keys: an indexed heap with four children per node.
//
// Ties are broken by the lower vertex, so the order of collapses depends on the keys alone.
#ifndef NMC_ENCODER_DOMAIN_VERTEX_QUEUE_H_
#define NMC_ENCODER_DOMAIN_VERTEX_QUEUE_H_

#include <cstdint>
#include <vector>

namespace nmc {

class VertexQueue {
 public:
  explicit VertexQueue(std::size_t vertex_count) : position_(vertex_count, kAbsent), key_(vertex_count, 0) {}

  bool empty() const { return heap_.empty(); }
  std::uint32_t top() const { return heap_.front(); }
  double key(std::uint32_t v) const { return key_[v]; }
  bool contains(std::uint32_t v) const { return position_[v] != kAbsent; }

  /// Inserts v or changes its key. O(log n).
  void set(std::uint32_t v, double key) {
    if (position_[v] == kAbsent) {
      position_[v] = static_cast<std::uint32_t>(heap_.size());
      heap_.push_back(v);
      key_[v] = key;
      rise(position_[v]);
      return;
    }
    key_[v] = key;
    rise(position_[v]);
    sink(position_[v]);
  }

  void remove(std::uint32_t v) {
    const std::uint32_t hole = position_[v];
    if (hole == kAbsent) return;
    position_[v] = kAbsent;
    const std::uint32_t last = heap_.back();
    heap_.pop_back();
    if (last == v) return;
    place(hole, last);
    rise(hole);
    sink(position_[last]);
  }

 private:
  static constexpr std::uint32_t kAbsent = 0xffffffffu;

  bool before(std::uint32_t a, std::uint32_t b) const {
    return key_[a] < key_[b] || (key_[a] == key_[b] && a < b);
  }
  void place(std::uint32_t at, std::uint32_t v) {
    heap_[at] = v;
    position_[v] = at;
  }
  void rise(std::uint32_t at) {
    const std::uint32_t v = heap_[at];
    while (at > 0) {
      const std::uint32_t parent = (at - 1) / 4;
      if (!before(v, heap_[parent])) break;
      place(at, heap_[parent]);
      at = parent;
    }
    place(at, v);
  }
  void sink(std::uint32_t at) {
    const std::uint32_t v = heap_[at];
    const auto size = static_cast<std::uint32_t>(heap_.size());
    for (;;) {
      const std::uint32_t first = 4 * at + 1;
      if (first >= size) break;
      std::uint32_t best = first;
      for (std::uint32_t child = first + 1; child < first + 4 && child < size; ++child)
        if (before(heap_[child], heap_[best])) best = child;
      if (!before(heap_[best], v)) break;
      place(at, heap_[best]);
      at = best;
    }
    place(at, v);
  }

  std::vector<std::uint32_t> heap_;
  std::vector<std::uint32_t> position_;
  std::vector<double> key_;
};

}  // namespace nmc

#endif  // NMC_ENCODER_DOMAIN_VERTEX_QUEUE_H_

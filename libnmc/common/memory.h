// SPDX-License-Identifier: Apache-2.0
// Fallible, counted memory. Nothing in libnmc allocates in any other way, so a limit on bytes is a limit on
// all bytes, and a failed allocation is a status, never an abort.
#ifndef NMC_COMMON_MEMORY_H_
#define NMC_COMMON_MEMORY_H_

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <type_traits>
#include <utility>

#include "libnmc/common/seldom.h"

namespace nmc {

/// A budget of bytes over a pair of allocation functions. Not thread-safe: one per decoder.
class Memory {
 public:
  using AllocateFunction = void* (*)(void* user, std::size_t size);
  using ReleaseFunction = void (*)(void* user, void* pointer);

  Memory() = default;
  Memory(AllocateFunction allocate_function, ReleaseFunction release_function, void* user,
         std::uint64_t limit)
      : allocate_(allocate_function), release_(release_function), user_(user), limit_(limit) {}

  /// Null when the limit would be passed or the allocation function fails; `limit_reached()` tells which.
  void* allocate(std::size_t size) {
    if (size > limit_ - used_) {
      limit_reached_ = true;
      return nullptr;
    }
    void* pointer = allocate_ ? allocate_(user_, size) : std::malloc(size);
    if (pointer) {
      used_ += size;
      if (used_ > peak_) peak_ = used_;
    }
    return pointer;
  }
  void release(void* pointer, std::size_t size) {
    if (!pointer) return;
    used_ -= size;
    if (release_)
      release_(user_, pointer);
    else
      std::free(pointer);
  }
  bool limit_reached() const { return limit_reached_; }
  void forget_limit_reached() { limit_reached_ = false; }
  std::uint64_t used() const { return used_; }
  std::uint64_t peak() const { return peak_; }
  std::uint64_t remaining() const { return limit_ - used_; }

 private:
  AllocateFunction allocate_ = nullptr;
  ReleaseFunction release_ = nullptr;
  void* user_ = nullptr;
  std::uint64_t limit_ = ~std::uint64_t{0};
  std::uint64_t used_ = 0;
  std::uint64_t peak_ = 0;
  bool limit_reached_ = false;
};

// The part of an array that is the same for all types, and seldom run: not to be repeated wherever one is
// used.
namespace memory_internal {

NMC_SELDOM inline void release(Memory* memory, void* data, std::size_t size) {
  if (memory)
    memory->release(data, size);
  else
    std::free(data);
}

/// `new_size` bytes that begin with the first `used` of `data`, whose `old_size` are given back; null, and
/// nothing changed, when they are not to be had.
NMC_SELDOM inline void* grown(Memory* memory, void* data, std::size_t used, std::size_t old_size,
                              std::size_t new_size) {
  void* pointer = memory ? memory->allocate(new_size) : std::malloc(new_size);
  if (!pointer) return nullptr;
  if (used) std::memcpy(pointer, data, used);
  release(memory, data, old_size);
  return pointer;
}

}  // namespace memory_internal

/// A growable array of trivially copyable elements whose growth can fail. New elements are zero bytes.
/// Move-only. A default-constructed array allocates with malloc and has no limit.
template <class T>
class Array {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  Array() = default;
  explicit Array(Memory* memory) : memory_(memory) {}
  Array(const Array&) = delete;
  Array& operator=(const Array&) = delete;
  Array(Array&& other) noexcept { swap(other); }
  Array& operator=(Array&& other) noexcept {
    swap(other);
    return *this;
  }
  ~Array() { release(); }

  /// Where memory comes from. Only while the array is empty and has no capacity.
  void set_memory(Memory* memory) { memory_ = memory; }

  /// Keeps the elements below min(old size, count). False, and nothing changed, when memory is not to be had.
  [[nodiscard]] bool resize(std::size_t count) {
    if (count > capacity_ && !reserve(count)) return false;
    if (count > size_) std::memset(static_cast<void*>(data_ + size_), 0, (count - size_) * sizeof(T));
    size_ = count;
    return true;
  }
  /// The same, but new elements hold anything: for those that are written before they are read.
  [[nodiscard]] bool resize_unset(std::size_t count) {
    if (count > capacity_ && !reserve(count)) return false;
    size_ = count;
    return true;
  }
  [[nodiscard]] bool reserve(std::size_t count) {
    if (count <= capacity_) return true;
    if (count > ~std::size_t{0} / 2 / sizeof(T)) return false;
    void* pointer =
        memory_internal::grown(memory_, data_, size_ * sizeof(T), capacity_ * sizeof(T), count * sizeof(T));
    if (!pointer) return false;
    data_ = static_cast<T*>(pointer);
    capacity_ = count;
    return true;
  }
  [[nodiscard]] bool push_back(const T& value) {
    const T copy = value;
    if (size_ == capacity_ && !reserve(capacity_ ? capacity_ * 2 : 16)) return false;
    data_[size_++] = copy;
    return true;
  }
  [[nodiscard]] bool assign(std::size_t count, const T& value) {
    size_ = 0;
    if (!reserve(count)) return false;
    size_ = count;
    for (std::size_t i = 0; i < count; ++i) data_[i] = value;
    return true;
  }
  /// Appends `count` elements from `values`, which must not lie in this array. Capacity at least doubles when
  /// it has to grow and memory allows, so many small pieces cost linear time. False, and nothing changed,
  /// when memory is not to be had.
  [[nodiscard]] bool append(const T* values, std::size_t count) {
    if (count > ~std::size_t{0} / 4 / sizeof(T) || size_ > ~std::size_t{0} / 4 / sizeof(T)) return false;
    const std::size_t needed = size_ + count;
    if (needed > capacity_) {
      const bool may_double = !memory_ || memory_->remaining() / sizeof(T) >= 2 * capacity_;
      if (!(may_double && needed < 2 * capacity_ && reserve(2 * capacity_)) && !reserve(needed)) return false;
    }
    std::memcpy(static_cast<void*>(data_ + size_), values, count * sizeof(T));
    size_ = needed;
    return true;
  }
  /// Drops the elements from `count` on; count <= size().
  void truncate(std::size_t count) { size_ = count; }
  void clear() { size_ = 0; }
  /// Gives the memory back.
  void release() {
    memory_internal::release(memory_, data_, capacity_ * sizeof(T));
    data_ = nullptr;
    size_ = capacity_ = 0;
  }
  void swap(Array& other) noexcept {
    std::swap(memory_, other.memory_);
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    std::swap(capacity_, other.capacity_);
  }

  T* data() { return data_; }
  const T* data() const { return data_; }
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  T& operator[](std::size_t i) { return data_[i]; }
  const T& operator[](std::size_t i) const { return data_[i]; }
  T* begin() { return data_; }
  T* end() { return data_ + size_; }
  const T* begin() const { return data_; }
  const T* end() const { return data_ + size_; }

 private:
  Memory* memory_ = nullptr;
  T* data_ = nullptr;
  std::size_t size_ = 0;
  std::size_t capacity_ = 0;
};

}  // namespace nmc

#endif  // NMC_COMMON_MEMORY_H_

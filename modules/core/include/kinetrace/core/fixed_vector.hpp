// A vector whose capacity is fixed when it is made: storage comes from an Arena.
#pragma once

#include <cassert>
#include <cstddef>
#include <span>

#include "kinetrace/core/arena.hpp"

namespace kinetrace {

/// Push, erase and iterate within a fixed capacity; never allocates. Copying copies the handle, not the elements.
template <typename T>
class FixedVector {
 public:
  FixedVector() = default;
  FixedVector(Arena& arena, std::size_t capacity) : storage_(arena.take<T>(capacity)) {}

  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  [[nodiscard]] std::size_t capacity() const noexcept { return storage_.size(); }
  [[nodiscard]] bool empty() const noexcept { return size_ == 0; }
  [[nodiscard]] bool full() const noexcept { return size_ == storage_.size(); }

  /// Appends; false (and nothing changes) at capacity. The caller counts what it drops.
  [[nodiscard]] bool push_back(const T& value) noexcept {
    if (full()) {
      return false;
    }
    storage_[size_++] = value;
    return true;
  }
  void pop_back() noexcept {
    assert(size_ > 0);
    --size_;
  }
  /// Removes element `i` by moving the last one into its place: constant time, order not kept.
  void swap_remove(std::size_t i) noexcept {
    assert(i < size_);
    storage_[i] = storage_[size_ - 1];
    --size_;
  }
  void clear() noexcept { size_ = 0; }
  /// Grows with value-initialised elements, or shrinks; the size is clamped to the capacity.
  void resize(std::size_t size) noexcept {
    const std::size_t clamped = size < storage_.size() ? size : storage_.size();
    for (std::size_t i = size_; i < clamped; ++i) {
      storage_[i] = T{};
    }
    size_ = clamped;
  }

  [[nodiscard]] T& operator[](std::size_t i) noexcept {
    assert(i < size_);
    return storage_[i];
  }
  [[nodiscard]] const T& operator[](std::size_t i) const noexcept {
    assert(i < size_);
    return storage_[i];
  }
  [[nodiscard]] T& back() noexcept { return (*this)[size_ - 1]; }
  [[nodiscard]] const T& back() const noexcept { return (*this)[size_ - 1]; }
  [[nodiscard]] T* begin() noexcept { return storage_.data(); }
  [[nodiscard]] T* end() noexcept { return storage_.data() + size_; }
  [[nodiscard]] const T* begin() const noexcept { return storage_.data(); }
  [[nodiscard]] const T* end() const noexcept { return storage_.data() + size_; }
  [[nodiscard]] std::span<T> span() noexcept { return storage_.first(size_); }
  [[nodiscard]] std::span<const T> span() const noexcept { return storage_.first(size_); }

 private:
  std::span<T> storage_;
  std::size_t size_ = 0;
};

}  // namespace kinetrace

// A bounded, wait-free queue between two threads.
#pragma once

#include <atomic>
#include <cstddef>
#include <span>

#include "kinetrace/core/arena.hpp"

namespace kinetrace::publishing {

/// Single producer, single consumer, wait-free; a full queue refuses. Storage from an arena.
template <typename T>
// Each thread writes to a cache line of its own.
// NOLINTNEXTLINE(clang-analyzer-optin.performance.Padding)
class EventQueue {
 public:
  EventQueue() = default;
  EventQueue(Arena& arena, std::size_t capacity) : slots_(arena.take<T>(capacity)) {}

  /// Producer: false, and nothing changes, when full.
  [[nodiscard]] bool push(const T& event) noexcept {
    const std::size_t end = end_.load(std::memory_order_relaxed);  // Only we write it.
    // Acquire: the consumer has read the slot before we write it again.
    if (end - begin_.load(std::memory_order_acquire) == slots_.size()) {
      return false;
    }
    slots_[end % slots_.size()] = event;
    end_.store(end + 1, std::memory_order_release);  // The consumer that sees it sees the slot.
    return true;
  }

  /// Consumer: false, and nothing changes, when empty.
  [[nodiscard]] bool pop(T& event) noexcept {
    const std::size_t begin = begin_.load(std::memory_order_relaxed);  // Only we write it.
    if (begin == end_.load(std::memory_order_acquire)) {               // Pairs with push.
      return false;
    }
    event = slots_[begin % slots_.size()];
    begin_.store(begin + 1, std::memory_order_release);  // The slot is read.
    return true;
  }

 private:
  std::span<T> slots_;
  alignas(64) std::atomic<std::size_t> end_ = 0;
  alignas(64) std::atomic<std::size_t> begin_ = 0;
};

}  // namespace kinetrace::publishing

// Passes the newest value from one thread to another; neither ever waits.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace kinetrace {

/// Three slots of one producer and one consumer, wait-free: each side owns one, the third is exchanged. A value not
/// fetched before the next one is published is superseded.
template <typename T>
// Each thread writes to cache lines of its own.
// NOLINTNEXTLINE(clang-analyzer-optin.performance.Padding)
class LatestValue {
 public:
  LatestValue() = default;
  /// Fills the slots with results of `make()`, one after the other.
  template <typename Make>
  explicit LatestValue(const Make& make) : slots_{make(), make(), make()} {}

  /// Producer: the slot to fill; it still holds an older value.
  [[nodiscard]] T& slot() noexcept { return slots_[filling_]; }

  /// Producer: makes the slot's content the newest value. True if one was superseded.
  bool publish() noexcept {
    // Release: the consumer that gets this index sees the written value. Acquire: the consumer has finished reading the
    // returned slot before it is overwritten.
    const std::uint8_t previous =
        exchanged_.exchange(static_cast<std::uint8_t>(filling_ | kFresh), std::memory_order_acq_rel);
    filling_ = previous & kIndex;
    return (previous & kFresh) != 0;
  }

  /// Consumer: the newest value since the last call, null if there is none. Valid until the next call that returns one.
  [[nodiscard]] const T* fetch() noexcept {
    // Relaxed: only a hint whether to exchange; the exchange orders.
    if ((exchanged_.load(std::memory_order_relaxed) & kFresh) == 0) {
      return nullptr;
    }
    // As in `publish`, with the roles changed.
    reading_ = exchanged_.exchange(reading_, std::memory_order_acq_rel) & kIndex;
    return &slots_[reading_];
  }

 private:
  static constexpr std::uint8_t kFresh = 4;
  static constexpr std::uint8_t kIndex = 3;

  std::array<T, 3> slots_{};
  std::uint8_t filling_ = 0;
  alignas(64) std::atomic<std::uint8_t> exchanged_ = 1;
  alignas(64) std::uint8_t reading_ = 2;
};

}  // namespace kinetrace

// The newest value from one thread to another, where neither ever waits.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace kinetrace {

/// Three slots of one producer and one consumer, wait-free: each side owns one, the third is exchanged. A value that
/// the consumer did not fetch before the next one came is superseded.
template <typename T>
// What each thread writes lies in a cache line of its own.
// NOLINTNEXTLINE(clang-analyzer-optin.performance.Padding)
class LatestValue {
 public:
  LatestValue() = default;
  /// Slots that `make()` fills in, one after the other.
  template <typename Make>
  explicit LatestValue(const Make& make) : slots_{make(), make(), make()} {}

  /// Producer: the slot to fill in; what it holds is an older value.
  [[nodiscard]] T& slot() noexcept { return slots_[filling_]; }

  /// Producer: makes the slot's content the newest value. True if one was superseded.
  bool publish() noexcept {
    // Release: the consumer that gets this index sees what was written. Acquire: what the consumer read in the slot
    // that comes back was read before we overwrite it.
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

// Random numbers by key, independent of the order of use: the same seed gives the same pixels in any order.
#pragma once

#include <cmath>
#include <cstdint>

namespace kinetrace::simulator {

// Always inlined: kernels of several instruction sets use them in registers and must not share one compiled copy.

/// Mixes all bits of `x` (C. Wellons, "Prospecting for hash functions", 2018: lowbias32). A word, or a vector of words.
template <typename Word>
[[nodiscard, gnu::always_inline]] constexpr Word mixed(Word x) noexcept {
  x ^= x >> 16U;
  x *= 0x7feb352dU;
  x ^= x >> 15U;
  x *= 0x846ca68bU;
  x ^= x >> 16U;
  return x;
}

/// A hash extended by one key.
template <typename Word>
[[nodiscard, gnu::always_inline]] constexpr Word hash_step(Word hash, Word key) noexcept {
  return mixed(hash ^ (key + 0x9e3779b9U + (hash << 6U)));
}

template <typename... Keys>
[[nodiscard, gnu::always_inline]] constexpr std::uint32_t hash_of(std::uint32_t first, Keys... keys) noexcept {
  std::uint32_t hash = mixed(first + 0x9e3779b9U);
  ((hash = hash_step(hash, static_cast<std::uint32_t>(keys))), ...);
  return hash;
}

/// In [0, 1).
[[nodiscard, gnu::always_inline]] constexpr float unit_float(std::uint32_t hash) noexcept {
  return static_cast<float>(hash >> 8U) * 0x1p-24F;
}

/// A stream of random numbers named by its keys.
class Random {
 public:
  template <typename... Keys>
  explicit Random(std::uint32_t seed, Keys... keys) : key_(hash_of(seed, keys...)) {}

  [[nodiscard]] std::uint32_t bits() noexcept { return hash_of(key_, counter_++); }
  /// In [0, 1).
  [[nodiscard]] double unit() noexcept { return static_cast<double>(unit_float(bits())); }
  [[nodiscard]] double uniform(double low, double high) noexcept { return low + (high - low) * unit(); }
  /// In [0, count).
  [[nodiscard]] int index(int count) noexcept { return static_cast<int>(unit() * count); }
  [[nodiscard]] bool chance(double probability) noexcept { return unit() < probability; }
  /// Standard normal (Box and Muller, 1958).
  [[nodiscard]] double normal() noexcept {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - unit()));
    return radius * std::cos(6.283185307179586 * unit());
  }

 private:
  std::uint32_t key_;
  std::uint32_t counter_ = 0;
};

}  // namespace kinetrace::simulator

// Window columns as bits of a mask.
#pragma once

#include <cstddef>
#include <cstdint>

namespace kinetrace::sfm {

[[nodiscard]] constexpr std::uint32_t bit(std::size_t column) noexcept {
  return 1U << column;
}

/// Bits of columns 0..count-1; count may be all 32.
[[nodiscard]] constexpr std::uint32_t first_bits(std::size_t count) noexcept {
  return static_cast<std::uint32_t>((std::uint64_t{1} << count) - 1U);
}

}  // namespace kinetrace::sfm

// The checksum of Ethernet, zip and PNG (ISO/IEC 15948, annex D), eight bytes at a time.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

namespace kinetrace {

namespace detail {

using CrcTables = std::array<std::array<std::uint32_t, 256>, 8>;

constexpr CrcTables make_crc_tables() {
  constexpr std::uint32_t kPolynomial = 0xEDB88320U;
  CrcTables tables{};
  for (std::uint32_t byte = 0; byte < 256; ++byte) {
    std::uint32_t crc = byte;
    for (int bit = 0; bit < 8; ++bit) {
      crc = (crc >> 1U) ^ ((crc & 1U) != 0 ? kPolynomial : 0U);
    }
    tables[0][byte] = crc;
  }
  // Table k holds the CRC of a byte followed by k zero bytes.
  for (std::size_t k = 1; k < tables.size(); ++k) {
    for (std::size_t byte = 0; byte < 256; ++byte) {
      const std::uint32_t before = tables[k - 1][byte];
      tables[k][byte] = (before >> 8U) ^ tables[0][before & 0xFFU];
    }
  }
  return tables;
}

inline constexpr CrcTables kCrcTables = make_crc_tables();

}  // namespace detail

/// A running checksum: update(...).update(...).value().
class Crc32 {
 public:
  Crc32& update(std::span<const std::byte> bytes) noexcept {
    const auto& tables = detail::kCrcTables;
    std::size_t i = 0;
    for (; i + 8 <= bytes.size(); i += 8) {
      std::array<std::uint8_t, 8> b{};
      std::memcpy(b.data(), bytes.data() + i, b.size());
      for (std::size_t k = 0; k < 4; ++k) {
        b[k] = static_cast<std::uint8_t>(b[k] ^ (crc_ >> (8 * k)));
      }
      crc_ = tables[7][b[0]] ^ tables[6][b[1]] ^ tables[5][b[2]] ^ tables[4][b[3]] ^ tables[3][b[4]] ^ tables[2][b[5]] ^
             tables[1][b[6]] ^ tables[0][b[7]];
    }
    for (; i < bytes.size(); ++i) {
      crc_ = (crc_ >> 8U) ^ tables[0][(crc_ ^ static_cast<std::uint32_t>(bytes[i])) & 0xFFU];
    }
    return *this;
  }
  [[nodiscard]] std::uint32_t value() const noexcept { return ~crc_; }

 private:
  std::uint32_t crc_ = 0xFFFFFFFFU;
};

}  // namespace kinetrace

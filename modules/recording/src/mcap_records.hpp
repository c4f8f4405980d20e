// The records of an MCAP file, as bytes: little endian, each an opcode, a length and its content.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace kinetrace::recording {

enum class McapOpcode : std::uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kStatistics = 0x0B,
  kSummaryOffset = 0x0E,
  kDataEnd = 0x0F,
};

inline constexpr std::array<std::uint8_t, 8> kMcapMagic{0x89, 'M', 'C', 'A', 'P', '0', '\r', '\n'};
inline constexpr std::size_t kMcapPrefixBytes = 9;  ///< Opcode and length of a record.

/// Buffer for appending records.
class McapBytes {
 public:
  template <typename Integer>
  McapBytes& number(Integer value) {
    for (std::size_t i = 0; i < sizeof(Integer); ++i) {
      bytes_.push_back(static_cast<std::byte>(static_cast<std::uint64_t>(value) >> (8 * i)));
    }
    return *this;
  }
  McapBytes& raw(std::span<const std::byte> bytes) {
    const std::size_t at = bytes_.size();
    bytes_.resize(at + bytes.size());
    std::copy(bytes.begin(), bytes.end(), bytes_.begin() + static_cast<std::ptrdiff_t>(at));
    return *this;
  }
  /// A string, with its length.
  McapBytes& text(std::string_view text) {
    return number(static_cast<std::uint32_t>(text.size())).raw(std::as_bytes(std::span(text)));
  }
  /// Appends the output of `fill(*this)`, preceded by its length as an Integer.
  template <typename Integer, typename Fill>
  McapBytes& sized(Fill&& fill) {
    const std::size_t at = bytes_.size();
    number(Integer{0});
    fill(*this);
    const std::uint64_t size = bytes_.size() - at - sizeof(Integer);
    for (std::size_t i = 0; i < sizeof(Integer); ++i) {
      bytes_[at + i] = static_cast<std::byte>(size >> (8 * i));
    }
    return *this;
  }
  template <typename Fill>
  McapBytes& record(McapOpcode opcode, Fill&& fill) {
    return number(static_cast<std::uint8_t>(opcode)).template sized<std::uint64_t>(fill);
  }

  void clear() noexcept { bytes_.clear(); }
  [[nodiscard]] std::size_t size() const noexcept { return bytes_.size(); }
  [[nodiscard]] std::span<const std::byte> span() const noexcept { return bytes_; }
  /// The bytes after the first `count`.
  [[nodiscard]] std::span<const std::byte> after(std::size_t count) const noexcept { return span().subspan(count); }

 private:
  std::vector<std::byte> bytes_;
};

/// Reads numbers back, in order.
class McapNumbers {
 public:
  explicit McapNumbers(std::span<const std::byte> bytes) noexcept : bytes_(bytes) {}
  template <typename Integer>
  [[nodiscard]] Integer next() noexcept {
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < sizeof(Integer); ++i) {
      value |= std::to_integer<std::uint64_t>(bytes_[i]) << (8 * i);
    }
    bytes_ = bytes_.subspan(sizeof(Integer));
    return static_cast<Integer>(value);
  }

 private:
  std::span<const std::byte> bytes_;
};

}  // namespace kinetrace::recording

// The first few warnings of a run, kept without allocating.
#pragma once

#include <array>
#include <cstddef>
#include <initializer_list>
#include <string_view>

namespace kinetrace::segmentation {

/// Keeps the first eight messages, truncated to their capacity.
class WarningLog {
 public:
  static constexpr std::size_t kCapacity = 8;
  static constexpr std::size_t kLineBytes = 512;

  [[nodiscard]] bool full() const noexcept { return size_ == kCapacity; }
  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  [[nodiscard]] std::string_view operator[](std::size_t index) const noexcept { return lines_[index].data(); }
  /// Joins the parts to one line.
  void add(std::initializer_list<std::string_view> parts) noexcept {
    if (full()) {
      return;
    }
    std::array<char, kLineBytes>& line = lines_[size_++];
    std::size_t used = 0;
    for (const std::string_view part : parts) {
      used += part.copy(line.data() + used, kLineBytes - 1 - used);
    }
    line[used] = '\0';
  }

 private:
  std::array<std::array<char, kLineBytes>, kCapacity> lines_{};
  std::size_t size_ = 0;
};

}  // namespace kinetrace::segmentation

// The frames of a recording, compactly: 24 bytes and one file stem each.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "kinetrace/core/export.hpp"
#include "kinetrace/core/result.hpp"

namespace kinetrace::hal {

/// Where one eye's files lie: folder + '/' + stem + suffix.
struct FrameFolder {
  std::string folder;
  std::string suffix;  ///< From the end of the stem on: ".png", "_leftImg8bit.png".
};

/// Frames in ascending order. Filled before start, constant afterwards.
class KINETRACE_API FrameList {
 public:
  struct Frame {
    std::int64_t frame_index = 0;
    std::int64_t timestamp_ns = 0;
    std::string_view left_stem;   ///< Empty if the left image is missing.
    std::string_view right_stem;  ///< Empty if the right image is missing.
    [[nodiscard]] std::string_view name() const noexcept { return left_stem.empty() ? right_stem : left_stem; }
    [[nodiscard]] bool complete() const noexcept { return !left_stem.empty() && !right_stem.empty(); }
  };

  FrameList() = default;
  FrameList(FrameFolder left, FrameFolder right) : left_(std::move(left)), right_(std::move(right)) {}

  /// Appends a frame; equal stems are stored once. Errors: kBadFormat if index or time do not increase, kCapacity
  /// beyond 4 GiB of stems.
  [[nodiscard]] Status add(const Frame& frame);

  [[nodiscard]] std::size_t size() const noexcept { return entries_.size(); }
  [[nodiscard]] bool empty() const noexcept { return entries_.empty(); }
  [[nodiscard]] Frame operator[](std::size_t i) const noexcept;
  [[nodiscard]] std::size_t complete_count() const noexcept;
  /// Nanoseconds from one frame number to the next, the median over the list; `fallback_ns` if there are no two frames.
  [[nodiscard]] std::int64_t median_period_ns(std::int64_t fallback_ns) const;
  /// Length of the longest file path that the list can produce, without the terminating zero.
  [[nodiscard]] std::size_t longest_path() const noexcept;

  [[nodiscard]] const FrameFolder& left() const noexcept { return left_; }
  [[nodiscard]] const FrameFolder& right() const noexcept { return right_; }

 private:
  static constexpr std::uint32_t kNoStem = UINT32_MAX;
  struct Entry {
    std::int64_t frame_index = 0;
    std::int64_t timestamp_ns = 0;
    std::uint32_t left_stem = kNoStem;  ///< Offset in `stems_` of a zero-terminated string.
    std::uint32_t right_stem = kNoStem;
  };
  [[nodiscard]] std::uint32_t store(std::string_view stem);
  [[nodiscard]] std::string_view stem_at(std::uint32_t offset) const noexcept;

  FrameFolder left_;
  FrameFolder right_;
  std::string stems_;
  std::vector<Entry> entries_;
  std::size_t longest_stem_ = 0;
};

}  // namespace kinetrace::hal

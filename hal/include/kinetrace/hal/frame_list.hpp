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

/// Where one view's files lie: folder + '/' + stem + suffix.
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

  static constexpr std::int64_t kMaxFrameIndex = INT32_MAX - 1;
  /// Range of times in ns: 1933 to 2116 if counted from 1970. Differences within it do not overflow.
  static constexpr std::int64_t kMinTime_ns = -(std::int64_t{1} << 60);
  static constexpr std::int64_t kMaxTime_ns = std::int64_t{1} << 62;
  [[nodiscard]] static constexpr bool holds_time(std::int64_t timestamp_ns) noexcept {
    return timestamp_ns >= kMinTime_ns && timestamp_ns <= kMaxTime_ns;
  }
  [[nodiscard]] static constexpr bool holds(std::int64_t frame_index, std::int64_t timestamp_ns) noexcept {
    return frame_index >= 0 && frame_index <= kMaxFrameIndex && holds_time(timestamp_ns);
  }

  FrameList() = default;
  /// `times_source`: where numbers and times come from, for errors; the left folder if it is empty.
  FrameList(FrameFolder left, FrameFolder right, std::string times_source = {})
      : left_(std::move(left)),
        right_(std::move(right)),
        times_source_(times_source.empty() ? left_.folder : std::move(times_source)) {}

  /// Appends a frame; equal stems are stored once. Errors: kBadFormat if index or time do not increase or are out of
  /// range, kCapacity beyond 4 GiB of stems.
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
  [[nodiscard]] const std::string& times_source() const noexcept { return times_source_; }

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
  std::string times_source_;
  std::string stems_;
  std::vector<Entry> entries_;
  std::size_t longest_stem_ = 0;
};

}  // namespace kinetrace::hal

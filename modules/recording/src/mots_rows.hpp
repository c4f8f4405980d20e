// The rows of mots.txt.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "buffered_file.hpp"
#include "kinetrace/core/frame_result.hpp"

namespace kinetrace::recording {

inline constexpr std::int64_t kMotsIdsPerClass = 1000;
inline constexpr std::int64_t kMotsLargeIds = 100'000'000;  ///< Above every class_id * 1000 + 999.
/// class_id * 1000 + track_id as KITTI MOTS has it; ids from 1000 on do not fit and become 100 000 000 + track_id.
[[nodiscard]] std::int64_t mots_object_id(std::uint16_t class_id, std::uint32_t track_id) noexcept;
/// The inverse; outside the range of track ids if the two are inconsistent.
[[nodiscard]] std::int64_t mots_track_id(std::int64_t class_id, std::int64_t object_id) noexcept;

/// Writes one row per track that has a pixel, in the order of frames. Rows of a tentative track wait, and all after
/// them, until the track is confirmed, and are dropped if it ends before. Never allocates.
class MotsRows {
 public:
  MotsRows() = default;
  /// `buffer` holds the run lengths of waiting rows. Once it or kMaxWaitingRows is full, tentative ones are dropped.
  explicit MotsRows(std::span<std::byte> buffer) noexcept : run_lengths_(buffer) {}

  /// Adds the newest frame. Returns the number of rows written to `out`.
  int append(const FrameResult& result, BufferedWriter& out) noexcept;
  /// After the last frame.
  int finish(BufferedWriter& out) noexcept;

  static constexpr std::size_t kMaxWaitingRows = 512;

 private:
  enum class State : std::uint8_t { kTentative, kConfirmed, kDropped };
  struct Row {
    std::int64_t frame = 0;
    std::uint32_t track_id = 0;
    std::uint16_t class_id = 0;
    State state = State::kTentative;
    int height_px = 0;
    int width_px = 0;
    std::size_t size = 0;  ///< Of its run lengths.
  };

  static void write_head(const Row& row, BufferedWriter& out) noexcept;
  void decide(std::span<const Track> tracks) noexcept;
  int write_decided(BufferedWriter& out) noexcept;
  int add(Row row, LabelView labels, const Track& track, BufferedWriter& out) noexcept;
  [[nodiscard]] bool try_add(Row row, LabelView labels, const Track& track) noexcept;

  std::span<std::byte> run_lengths_;
  std::size_t used_ = 0;
  std::array<Row, kMaxWaitingRows> rows_{};
  std::size_t count_ = 0;
};

}  // namespace kinetrace::recording

// A finished run indexed by frame and by track.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "kinetrace/core/result.hpp"
#include "kinetrace/recording/run_reader.hpp"

namespace kinetrace::figure {

/// All rows of one track, by frame.
struct TrackRows {
  std::uint32_t track_id = 0;
  std::uint16_t class_id = 0;                     ///< The last one, also in `rows`.
  std::vector<const recording::ObjectRow*> rows;  ///< Into the run.
  bool moving = false;                            ///< Moves in at least three frames and a fifth of all.
};

/// Owns the rows; pointers and spans into it are valid for its lifetime and survive a move.
class FigureRun {
 public:
  /// Errors: those of read_run; kBadFormat (a run without a single frame).
  [[nodiscard]] static Result<FigureRun> open(const std::filesystem::path& directory);
  /// From rows in memory. The same errors.
  [[nodiscard]] static Result<FigureRun> from(recording::Run run);

  [[nodiscard]] const recording::Run& run() const noexcept { return run_; }
  [[nodiscard]] std::int64_t first_frame() const noexcept { return run_.camera.front().frame; }
  [[nodiscard]] std::int64_t last_frame() const noexcept { return run_.camera.back().frame; }
  /// Null if the run has no such frame.
  [[nodiscard]] const recording::CameraRow* camera_at(std::int64_t frame) const noexcept;
  [[nodiscard]] std::span<const recording::ObjectRow> objects_at(std::int64_t frame) const noexcept;
  /// By id.
  [[nodiscard]] const std::vector<TrackRows>& tracks() const noexcept { return tracks_; }
  /// Null if the run has no such track.
  [[nodiscard]] const TrackRows* track(std::uint32_t track_id) const noexcept;
  /// Seconds from the run's first frame.
  [[nodiscard]] double seconds(std::int64_t timestamp_ns) const noexcept;

 private:
  recording::Run run_;
  std::vector<TrackRows> tracks_;
};

/// "car", "pedestrian", or "object" for moving regions and every other class.
[[nodiscard]] std::string class_name(std::uint16_t class_id);
/// "car 12".
[[nodiscard]] std::string track_name(std::uint16_t class_id, std::uint32_t track_id);
/// A number with this many decimals and its unit: "7.6 m/s".
[[nodiscard]] std::string with_unit(double value, int decimals, const char* unit);

}  // namespace kinetrace::figure

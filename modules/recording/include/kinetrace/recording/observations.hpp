// Observations of a run: image positions of reconstructed points, frame by frame, for refinement after the run.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>

#include "kinetrace/core/export.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/recording/run_reader.hpp"

namespace kinetrace::recording {

/// A record of observations.bin, little-endian: one point of one body in one frame.
struct Observation {
  std::uint32_t track_id = 0;  ///< 0: the background.
  std::uint32_t point_id = 0;  ///< Id within the body; above 0.
  std::int32_t frame = 0;
  float u_left_px = 0.F;
  float v_px = 0.F;        ///< Mean row of the pair.
  float u_right_px = 0.F;  ///< NaN where only the left view shows the point.
};
static_assert(sizeof(Observation) == 24, "the layout of the file");

/// Reads observations.bin frame by frame. For host-side tools; holds one frame.
class KINETRACE_API ObservationReader {
 public:
  /// Of an unfinished run, all whole records are read. Errors: kNotFound (the run recorded none), kBadFormat (another
  /// kind of file, cut off, or not of the length in run.json), kIo.
  [[nodiscard]] static Result<ObservationReader> open(const Run& run);

  ObservationReader(ObservationReader&&) noexcept;
  ObservationReader& operator=(ObservationReader&&) noexcept;
  ~ObservationReader();

  /// The observations of the next frame with any, in recorded order; empty after the last one. Valid until the next
  /// call. Errors: kBadFormat (frames out of order, values that are not finite, no point), with the file and the
  /// record's number; kIo.
  [[nodiscard]] Result<std::span<const Observation>> next_frame();

 private:
  struct Impl;
  explicit ObservationReader(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace kinetrace::recording

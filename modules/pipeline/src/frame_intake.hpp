// Check of the pairs given to the pipeline: size, order of time, one sequence.
#pragma once

#include <cstdint>

#include "kinetrace/core/frame.hpp"
#include "kinetrace/core/result.hpp"

namespace kinetrace::pipeline {

class FrameIntake {
 public:
  explicit FrameIntake(const StereoGeometry& geometry) : geometry_(geometry) {}

  /// Errors: kInvalidArgument (size differs from the geometry, time does not advance), kIllegalState (after close()).
  [[nodiscard]] Status check(const RectifiedPair& pair) const;
  /// This pair has been processed.
  void count(const RectifiedPair& pair) noexcept {
    ++frames_;
    last_timestamp_ns_ = pair.timestamp_ns;
  }
  /// No more pairs; true the first time.
  bool close() noexcept {
    const bool first = !closed_;
    closed_ = true;
    return first;
  }

  [[nodiscard]] std::uint64_t frames() const noexcept { return frames_; }
  /// Of the last pair that was counted.
  [[nodiscard]] std::int64_t last_timestamp_ns() const noexcept { return last_timestamp_ns_; }

 private:
  StereoGeometry geometry_;
  std::int64_t last_timestamp_ns_ = 0;
  std::uint64_t frames_ = 0;
  bool closed_ = false;
};

}  // namespace kinetrace::pipeline

// Stands between any camera and the pipeline, so that only frames pass that the pipeline can trust.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>

#include "kinetrace/core/export.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/hal/stereo_camera.hpp"
#include "kinetrace/hal/timeline_guard.hpp"

namespace kinetrace::hal {

struct FrameGuardConfig {
  /// Times that contradict the frame numbers are a jump of the clock and are mended; that one frame follows the other
  /// sooner than announced is no contradiction. Not for recordings: their times
  /// are what they are, and only those that do not advance are refused.
  bool mend_times = true;
};

/// True if the lower third or more of one eye's image is of one single value where the other eye sees something: what
/// is left of an image whose transfer broke off. Looks at a few hundred pixels.
[[nodiscard]] KINETRACE_API bool looks_cut_off(const StereoFrame& frame) noexcept;

/// Passes on the frames of another camera in order, each once, with times that advance. Skipped and counted are frames
/// that came before, of another size than announced, or cut off. States are those of the camera behind.
class KINETRACE_API FrameGuard final : public StereoCamera {
 public:
  FrameGuard(std::unique_ptr<StereoCamera> camera, const FrameGuardConfig& config);

  [[nodiscard]] Status open() override { return camera_->open(); }
  [[nodiscard]] Status start() override;
  /// Also kTimeout after many unusable frames in a row, though the camera has more and the time is not yet over.
  [[nodiscard]] Result<StereoFrame> next(std::chrono::milliseconds timeout) override;
  [[nodiscard]] Status stop() override { return camera_->stop(); }
  [[nodiscard]] Status recover() override { return camera_->recover(); }
  void close() noexcept override { camera_->close(); }

  [[nodiscard]] CameraState state() const noexcept override { return camera_->state(); }
  [[nodiscard]] const CameraInfo& info() const noexcept override { return camera_->info(); }
  /// Those of the camera behind, less what was skipped here.
  [[nodiscard]] const CameraCounters& counters() const noexcept override;

 private:
  /// Counts why, if the frame is not to pass.
  [[nodiscard]] bool passes(const StereoFrame& frame) noexcept;
  [[nodiscard]] double period_ns() const noexcept;
  [[nodiscard]] std::int64_t expected_step_ns(const StereoFrame& frame) const noexcept;

  std::unique_ptr<StereoCamera> camera_;
  FrameGuardConfig config_;
  TimelineGuard timeline_;
  CameraCounters own_;
  mutable CameraCounters sum_;
  bool begun_ = false;
  std::int64_t last_index_ = 0;
  std::int64_t last_time_ns_ = 0;
};

}  // namespace kinetrace::hal

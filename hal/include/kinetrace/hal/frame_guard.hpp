// Filters the frames of a camera, so that only valid ones reach the pipeline.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "kinetrace/core/export.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/hal/cut_off_detector.hpp"
#include "kinetrace/hal/stereo_camera.hpp"
#include "kinetrace/hal/timeline_guard.hpp"

namespace kinetrace::hal {

struct FrameGuardConfig {
  /// Corrects times that contradict the frame numbers: the clock has jumped. A step shorter than the announced period
  /// is no contradiction. Not for recordings: their times are kept, and only frames whose time does not advance are
  /// skipped.
  bool mend_times = true;
};

/// Passes on the frames of another camera in order, each once, with increasing times. Skips and counts frames that are
/// repeated, of another size than announced, or cut off (CutOffDetector). States are those of the other camera. The end
/// of a stream without a valid frame is kBadFormat, with the first unusable image.
class KINETRACE_API FrameGuard final : public StereoCamera {
 public:
  FrameGuard(std::unique_ptr<StereoCamera> camera, const FrameGuardConfig& config);

  [[nodiscard]] Status open() override { return camera_->open(); }
  [[nodiscard]] Status start() override;
  /// Also kTimeout after many unusable frames in a row, before the time is over.
  [[nodiscard]] Result<StereoFrame> next(std::chrono::milliseconds timeout) override;
  [[nodiscard]] Status stop() override { return camera_->stop(); }
  [[nodiscard]] Status recover() override { return camera_->recover(); }
  void close() noexcept override { camera_->close(); }
  [[nodiscard]] std::string image_name(std::int64_t frame_index, bool is_left) const override {
    return camera_->image_name(frame_index, is_left);
  }

  [[nodiscard]] CameraState state() const noexcept override { return camera_->state(); }
  [[nodiscard]] const CameraInfo& info() const noexcept override { return camera_->info(); }
  /// Counters of the camera, with the frames skipped here moved from delivered to skipped.
  [[nodiscard]] const CameraCounters& counters() const noexcept override;

 private:
  struct Unusable {
    std::int64_t frame_index = 0;
    bool is_left = false;
    int width_px = 0;
    int height_px = 0;
    int missing_rows = 0;  ///< 0: another size.
  };
  void note_unusable(const Unusable& unusable) noexcept;
  [[nodiscard]] Error explain(Error end) const;
  /// Counts the reason if the frame must not pass.
  [[nodiscard]] bool passes(const StereoFrame& frame) noexcept;
  [[nodiscard]] double period_ns() const noexcept;
  [[nodiscard]] std::int64_t expected_step_ns(const StereoFrame& frame) const noexcept;

  std::unique_ptr<StereoCamera> camera_;
  FrameGuardConfig config_;
  TimelineGuard timeline_;
  CutOffDetector cut_off_;
  std::optional<Unusable> first_unusable_;
  CameraCounters own_;
  mutable CameraCounters sum_;
  bool begun_ = false;
  std::int64_t last_index_ = 0;
  std::int64_t last_time_ns_ = 0;
};

}  // namespace kinetrace::hal

// The camera's path through the world, from the reconstruction of the static background.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>

#include "camera/camera_state.hpp"
#include "kinetrace/core/dwell_time.hpp"
#include "kinetrace/core/feature_frame.hpp"
#include "kinetrace/core/frame_result.hpp"
#include "kinetrace/sfm/body_reconstruction.hpp"

namespace kinetrace::pipeline {

/// Owns the background: its body frame is the world. Without known points the camera coasts on its last motion and
/// starts a new map in every frame, so that tracking resumes from the first frame with features.
class CameraTracker {
 public:
  explicit CameraTracker(sfm::BodyReconstruction background) : background_(std::move(background)) {}

  /// The pose of this frame from known points; returns T_prev_cam, the motion since the previous frame, `interval_ns`
  /// earlier. `is_cut`: there is a cut between the two, so that apparent matches of known points are false.
  [[nodiscard]] Se3 locate(const FeatureFrame& frame, std::int64_t interval_ns, bool is_cut);
  /// After locate(): the measurement of points changes from now on. Restarts the map at this frame's pose.
  void restart_map() {
    background_.begin(background_.estimate().T_body_cam, background_.estimate().status);
    background_.forget_motion();
  }
  /// Adds this frame to the window, with the background's features by the newest masks.
  void extend(const FeatureFrame& frame) { background_.extend(frame, kBackgroundLabel); }
  void end() { background_.end(); }

  [[nodiscard]] bool tracked() const noexcept { return background_.estimate().status == BodyStatus::kTracked; }
  /// `age` frames ago, by the window's current estimate.
  [[nodiscard]] CameraState state(std::size_t age) const;
  [[nodiscard]] CameraResult result(std::size_t age) const;
  /// Frames without known points so far.
  [[nodiscard]] std::uint64_t lost_frames() const noexcept { return camera_lost_frames_; }

  [[nodiscard]] sfm::BodyReconstruction& background() noexcept { return background_; }
  [[nodiscard]] const sfm::BodyReconstruction& background() const noexcept { return background_; }

 private:
  sfm::BodyReconstruction background_;
  DwellTime predicted_;
  std::uint64_t camera_lost_frames_ = 0;
};

}  // namespace kinetrace::pipeline

// The camera's path through the world, from its reconstruction of what stands still.
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

/// Owns the background: its body frame is the world. A camera that finds nothing it knows keeps its last motion and
/// starts a new map in every frame, so that the first frame with something to see is the one it starts from.
class CameraTracker {
 public:
  explicit CameraTracker(sfm::BodyReconstruction background) : background_(std::move(background)) {}

  /// The pose of this frame from known points; returns T_prev_cam, the motion since the frame before. `jumped`: the
  /// frame shows something else than the one before it, `interval_ns` earlier, so that what seems to be known is not.
  [[nodiscard]] Se3 locate(const FeatureFrame& frame, std::int64_t interval_ns, bool jumped);
  /// After locate(): points are measured differently from now on. The map begins anew at this frame's pose.
  void restart_map() {
    background_.begin(background_.estimate().T_body_cam, background_.estimate().status);
    background_.forget_motion();
  }
  /// This frame joins the window, with the features that are the background's by the newest masks.
  void extend(const FeatureFrame& frame) { background_.extend(frame, kBackgroundLabel); }
  void end() { background_.end(); }

  [[nodiscard]] bool tracked() const noexcept { return background_.estimate().status == BodyStatus::kTracked; }
  /// `age` frames ago, as the window knows it by now.
  [[nodiscard]] CameraState state(std::size_t age) const;
  [[nodiscard]] CameraResult result(std::size_t age) const;
  /// Frames in which the camera found nothing that it knew, so far.
  [[nodiscard]] std::uint64_t lost_frames() const noexcept { return camera_lost_frames_; }

  [[nodiscard]] sfm::BodyReconstruction& background() noexcept { return background_; }
  [[nodiscard]] const sfm::BodyReconstruction& background() const noexcept { return background_; }

 private:
  sfm::BodyReconstruction background_;
  DwellTime predicted_;
  std::uint64_t camera_lost_frames_ = 0;
};

}  // namespace kinetrace::pipeline

// Counts a run's results; the lines of a summary.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

#include <Eigen/Core>

#include "kinetrace/core/body.hpp"
#include "kinetrace/core/frame_result.hpp"
#include "kinetrace/core/stereo_geometry.hpp"
#include "kinetrace/recording/run_summary.hpp"

namespace kinetrace::app {

/// Accumulates final estimates in order of frames. An object counts once it has a pose, and as moved once its speed
/// differed significantly from zero. Never allocates.
class RunTally {
 public:
  void add(const FrameEstimate& finalised) noexcept;
  void add_camera(const Eigen::Vector3d& position_m) noexcept;
  void add_object(std::uint32_t track_id, BodyStatus status, bool moving) noexcept;

  [[nodiscard]] const recording::FoundSummary& found() const noexcept { return found_; }

 private:
  struct Seen {
    std::uint32_t track_id = 0;  ///< 0: none.
    bool moved = false;
    std::uint64_t last = 0;
  };
  /// Far more than are alive at once. At the capacity the least recently seen object is replaced: it would be counted
  /// again only if it returned after so many others.
  static constexpr std::size_t kRemembered = 512;

  [[nodiscard]] Seen& seen(std::uint32_t track_id) noexcept;

  recording::FoundSummary found_;
  Eigen::Vector3d camera_m_ = Eigen::Vector3d::Zero();
  std::array<Seen, kRemembered> seen_{};
  std::uint64_t rows_ = 0;
};

/// "640x480 pixels, focal length 500.0 px, baseline 0.537 m", for the user to compare with the rig.
[[nodiscard]] std::string geometry_text(const StereoGeometry& rectified);

/// "camera: 13.21 m in 20 frames; objects: 5, of which 3 moved". `looked_for`: false where segmentation is none.
[[nodiscard]] std::string found_text(const recording::FoundSummary& found, bool looked_for);

}  // namespace kinetrace::app

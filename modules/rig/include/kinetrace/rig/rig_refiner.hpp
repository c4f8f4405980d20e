// A rig's calibration, refined while the rig is in use.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/export.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/core/rig_correction.hpp"
#include "kinetrace/core/se3.hpp"
#include "kinetrace/core/stereo_geometry.hpp"
#include "kinetrace/rig/config.hpp"

namespace kinetrace::rig {

/// A background point in both images of one frame, with the frame's correction applied.
struct RigObservation {
  std::uint32_t id = 0;    ///< Of the feature.
  std::uint16_t slot = 0;  ///< Index in [0, max_features), constant for the life of the feature.
  Eigen::Vector2f left_px{0.F, 0.F};
  Eigen::Vector2f right_px{0.F, 0.F};
};

struct RigMeasurement;
struct RigRefinerStorage;
struct TwoViewPoint;

/// Estimates the right camera's pose against its calibration from pairs of frames between which the camera has moved
/// (two_view_calibration), and filters it over time (rig_filter). Applies only the certain part of a correction: the
/// estimate times max(0, 1 - (2 sigma / estimate)^2), which shrinks it towards the calibration (positive-part estimator
/// of James and Stein, 1961). States without evidence stay as calibrated, bit for bit.
///
/// Not observable: the baseline's length. Focal lengths are observable only if the camera turns by some degrees in a
/// window; otherwise their error looks like another depth, and their estimate stays. They are reported, not
/// applied. At rest and turning on the spot no state is updated.
///
/// Memory: three tables of features and the filter, 93 KiB for 1600 features.
class KINETRACE_API RigRefiner {
 public:
  /// Errors: kInvalidConfig, kCapacity.
  [[nodiscard]] static Result<RigRefiner> create(const RefineConfig& config, const StereoGeometry& geometry,
                                                 Arena& arena);
  [[nodiscard]] static std::size_t required_bytes(const RefineConfig& config);

  /// Correction for the next frame. Changes at `begin_frame` only.
  [[nodiscard]] const RigCorrection& correction() const noexcept { return estimate_.applied; }
  /// Begins the frame at this time.
  void begin_frame(std::int64_t timestamp_ns);
  /// Improved knowledge of the rig as it was in the frame before: observations made under the first correction are to
  /// be converted to the second one. The rig's own motion between the frames is excluded. Empty if nothing new is
  /// known.
  struct Revision {
    RigCorrection before;
    RigCorrection now;
  };
  [[nodiscard]] std::optional<Revision> revision() const {
    return revision_ ? std::optional(Revision{before_revision_, *revision_}) : std::nullopt;
  }
  /// True if the revision is so large that reconstructions have to begin anew.
  [[nodiscard]] bool must_restart() const;
  /// Adds the observations of a frame; `T_world_cam`, the pose of its camera, need not be exact.
  void observe(std::span<const RigObservation> observations, const Se3& T_world_cam);
  /// The following frames show another scene: observations so far do not continue.
  void forget_scene() noexcept;

  [[nodiscard]] const RigEstimate& estimate() const noexcept { return estimate_; }

 private:
  RigRefiner(const RefineConfig& config, const StereoGeometry& geometry, RigRefinerStorage& storage);
  /// Camera motion since the window began, as a fraction of the scene's median depth; and the number of points in both
  /// frames.
  struct Parallax {
    std::size_t shared = 0;
    double moved = 0.0;
  };
  [[nodiscard]] Parallax parallax_of(std::span<const RigObservation> observations, const Se3& T_world_cam);
  [[nodiscard]] bool window_ends(const Parallax& parallax, double window_s) const;
  /// Fills the storage; returns the number of points.
  [[nodiscard]] std::size_t pair_points(std::span<const RigObservation> observations, std::size_t shared);
  void measure(std::span<const TwoViewPoint> points, const Se3& T_now_before, double window_s);
  /// Adds the error due to lens distortion, which in a turn looks like a change of focal length.
  void add_focal_error(double turn_rad, RigMeasurement& measured);
  /// Right pixel as captured.
  [[nodiscard]] Eigen::Vector2f raw_right(const RigObservation& o) const;
  void begin_window(std::span<const RigObservation> observations, const Se3& T_world_cam);
  [[nodiscard]] RigCorrection shrunk_correction() const;
  [[nodiscard]] RigCorrection to_apply() const;
  void revise();
  void publish();

  RefineConfig config_;
  StereoGeometry geometry_;
  RigEstimate estimate_;
  std::optional<RigCorrection> pending_;   ///< Revision for the next frame.
  std::optional<RigCorrection> revision_;  ///< Revision of this frame.
  RigCorrection before_revision_;
  RigRefinerStorage* storage_;  ///< In the arena.
};

}  // namespace kinetrace::rig

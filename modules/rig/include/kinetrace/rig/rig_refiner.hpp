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

/// A point of the background in both images of one frame, corrected as the frame is.
struct RigObservation {
  std::uint32_t id = 0;    ///< Of the feature.
  std::uint16_t slot = 0;  ///< Index in [0, max_features), the same as long as the feature lives.
  Eigen::Vector2f left_px{0.F, 0.F};
  Eigen::Vector2f right_px{0.F, 0.F};
};

struct RigMeasurement;
struct RigRefinerStorage;
struct TwoViewPoint;

/// Estimates how the right camera stands against its calibration from pairs of frames between which the camera has
/// moved (two_view_calibration), and filters that over time (rig_filter). Corrects by what is surely known: the
/// estimate shrunk towards the calibration by what two of its standard deviations leave open (the positive part of the
/// estimator of James and Stein, 1961). What it has no evidence for stays as calibrated, bit for bit.
///
/// Not observed: the baseline's length. Focal lengths are where the camera turns by some degrees in a window; otherwise
/// their error looks the same as another depth, and their estimate stays. They are reported, not applied. At rest and
/// turning on the spot nothing changes.
///
/// Memory: two tables of features, 70 KiB for 1600.
class KINETRACE_API RigRefiner {
 public:
  /// Errors: kInvalidConfig, kCapacity.
  [[nodiscard]] static Result<RigRefiner> create(const RefineConfig& config, const StereoGeometry& geometry,
                                                 Arena& arena);
  [[nodiscard]] static std::size_t required_bytes(const RefineConfig& config);

  /// The next frame is to be corrected by this. Changes at `begin_frame` only.
  [[nodiscard]] const RigCorrection& correction() const noexcept { return estimate_.applied; }
  /// A frame at this time comes.
  void begin_frame(std::int64_t timestamp_ns);
  /// What is known about the rig as it was in the frame before has changed since then: what was measured under the
  /// first correction is to be understood under the second one. How the rig itself has changed between the frames is
  /// not part of it. Nothing where no more is known than before.
  struct Revision {
    RigCorrection before;
    RigCorrection now;
  };
  [[nodiscard]] std::optional<Revision> revision() const {
    return revision_ ? std::optional(Revision{before_revision_, *revision_}) : std::nullopt;
  }
  /// By so much that reconstructions have to begin anew.
  [[nodiscard]] bool must_restart() const;
  /// What the frame has shown; `T_world_cam` its camera's pose, which need not be exact.
  void observe(std::span<const RigObservation> observations, const Se3& T_world_cam);
  /// Frames that come show another scene: what was seen does not go on.
  void forget_scene() noexcept;

  [[nodiscard]] const RigEstimate& estimate() const noexcept { return estimate_; }

 private:
  RigRefiner(const RefineConfig& config, const StereoGeometry& geometry, RigRefinerStorage& storage);
  /// How far the camera has moved since the window began, over the depth of what it sees; and how many points both see.
  struct Parallax {
    std::size_t shared = 0;
    double moved = 0.0;
  };
  [[nodiscard]] Parallax parallax_of(std::span<const RigObservation> observations, const Se3& T_world_cam);
  [[nodiscard]] bool window_ends(const Parallax& parallax, double window_s) const;
  /// Into the storage; returns how many.
  [[nodiscard]] std::size_t pair_points(std::span<const RigObservation> observations, std::size_t shared);
  void measure(std::span<const TwoViewPoint> points, const Se3& T_now_before, double window_s);
  /// Of a bent lens, which looks like another focal length when the camera turns.
  void add_focal_error(double turn_rad, RigMeasurement& measured);
  /// As the camera gave it.
  [[nodiscard]] Eigen::Vector2f raw_right(const RigObservation& o) const;
  void begin_window(std::span<const RigObservation> observations, const Se3& T_world_cam);
  [[nodiscard]] RigCorrection surely_known_now() const;
  [[nodiscard]] RigCorrection to_apply() const;
  void revise();
  void publish();

  RefineConfig config_;
  StereoGeometry geometry_;
  RigEstimate estimate_;
  std::optional<RigCorrection> pending_;   ///< Revision that the next frame begins with.
  std::optional<RigCorrection> revision_;  ///< That this frame began with.
  RigCorrection before_revision_;
  RigRefinerStorage* storage_;  ///< Lives in the arena.
};

}  // namespace kinetrace::rig

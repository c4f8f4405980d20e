// The newest stretch of a camera's path with its fixes: what a run that still goes on is aligned by.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "kinetrace/core/result.hpp"
#include "kinetrace/geo/alignment.hpp"

namespace kinetrace::geo {

struct AlignmentWindowConfig {
  /// Odometry drifts, so that an old stretch no longer lies on the map as the newest one does.
  double max_path_m = 300.0;
  std::size_t max_poses = 3000;
  std::size_t max_fixes = 3000;
  /// Nearer poses are not kept: an accelerating vehicle (3 m/s2) is 3 mm off a straight line within this time.
  double min_pose_interval_s = 0.09;
  /// A camera that moves less within `max_rest_s` is at rest. Fixes at rest are not kept: they would push out the path.
  double min_pose_distance_m = 0.05;
  double max_rest_s = 0.5;
  double min_fix_interval_s = 0.04;
};

struct AlignmentWindowCounts {
  std::int64_t fixes = 0;                ///< That were offered.
  std::int64_t fixes_out_of_order = 0;   ///< Not later than the one before; left out.
  std::int64_t fixes_at_rest = 0;        ///< Left out.
  std::int64_t fixes_before_window = 0;  ///< Removed with the stretch of the path on which they came.
  std::int64_t restarts = 0;             ///< Of the path.
};

/// Poses and fixes in the order in which they come, each with its own clock. Memory is taken when it is made. At
/// capacity the oldest pose or fix is removed.
class AlignmentWindow {
 public:
  /// Errors: kInvalidArgument.
  [[nodiscard]] static Result<AlignmentWindow> create(const AlignmentWindowConfig& config);

  /// A pose that is not later than the one before begins another world: the window is cleared.
  void add(const PathPose& pose);
  void add(const Fix& fix);
  /// Where the path breaks off.
  void clear() noexcept;

  [[nodiscard]] std::span<const PathPose> path() const noexcept { return path_; }
  [[nodiscard]] std::span<const Fix> fixes() const noexcept { return fixes_; }
  [[nodiscard]] const AlignmentWindowCounts& counts() const noexcept { return counts_; }
  /// Travelled since the path began, up to the newest pose that is kept.
  [[nodiscard]] double distance_m() const noexcept { return distances_m_.empty() ? 0.0 : distances_m_.back(); }
  [[nodiscard]] bool is_at_rest() const noexcept;

 private:
  explicit AlignmentWindow(const AlignmentWindowConfig& config);
  void remove_oldest_pose();
  void remove_oldest_fix();

  AlignmentWindowConfig config_;
  std::vector<PathPose> path_;
  std::vector<double> distances_m_;  ///< By pose: travelled until there.
  std::vector<Fix> fixes_;
  std::vector<double> fix_distances_m_;  ///< By fix: travelled when it came.
  std::optional<std::int64_t> newest_pose_ns_;
  std::optional<std::int64_t> newest_fix_ns_;
  AlignmentWindowCounts counts_;
};

/// Covariance on the map of a point that is fixed to the camera `since_m` after the end of the path that was aligned:
/// `position_covariance`, which holds the drift of that path, and the drift since, a random walk (see AlignmentConfig).
[[nodiscard]] Eigen::Matrix3d live_covariance(const Alignment& alignment, const Eigen::Vector3d& map_m,
                                              double path_drift, double since_m);

}  // namespace kinetrace::geo

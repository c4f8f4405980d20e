// The newest stretch of a camera's path with its fixes, for the alignment of a live run.
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
  /// Odometry drifts: old stretches are no longer consistent with the newest one.
  double max_path_m = 300.0;
  std::size_t max_poses = 3000;
  std::size_t max_fixes = 3000;
  /// Nearer poses are not kept: an accelerating vehicle (3 m/s2) is 3 mm off a straight line within this time.
  double min_pose_interval_s = 0.09;
  /// A camera that moves less within `max_rest_s` is at rest. Fixes at rest are not kept, as they would displace the
  /// path's.
  double min_pose_distance_m = 0.05;
  double max_rest_s = 0.5;
  double min_fix_interval_s = 0.04;
};

struct AlignmentWindowCounts {
  std::int64_t fixes = 0;                ///< Number offered.
  std::int64_t fixes_out_of_order = 0;   ///< Not later than the previous one; left out.
  std::int64_t fixes_at_rest = 0;        ///< Left out.
  std::int64_t fixes_before_window = 0;  ///< Removed with their stretch of the path.
  std::int64_t restarts = 0;             ///< Of the path.
};

/// Poses and fixes in order of arrival, each with its own clock. All memory is allocated on creation. At capacity the
/// oldest pose or fix is removed.
class AlignmentWindow {
 public:
  /// Errors: kInvalidArgument.
  [[nodiscard]] static Result<AlignmentWindow> create(const AlignmentWindowConfig& config);

  /// A pose not later than the previous one begins another world: the window is cleared.
  void add(const PathPose& pose);
  void add(const Fix& fix);
  /// Ends the path.
  void clear() noexcept;

  [[nodiscard]] std::span<const PathPose> path() const noexcept { return path_; }
  [[nodiscard]] std::span<const Fix> fixes() const noexcept { return fixes_; }
  [[nodiscard]] const AlignmentWindowCounts& counts() const noexcept { return counts_; }
  /// Travelled since the path began, up to the newest pose kept.
  [[nodiscard]] double distance_m() const noexcept { return distances_m_.empty() ? 0.0 : distances_m_.back(); }
  [[nodiscard]] bool is_at_rest() const noexcept;

 private:
  explicit AlignmentWindow(const AlignmentWindowConfig& config);
  void remove_oldest_pose();
  void remove_oldest_fix();

  AlignmentWindowConfig config_;
  std::vector<PathPose> path_;
  std::vector<double> distances_m_;  ///< By pose: distance travelled.
  std::vector<Fix> fixes_;
  std::vector<double> fix_distances_m_;  ///< By fix: distance travelled on arrival.
  std::optional<std::int64_t> newest_pose_ns_;
  std::optional<std::int64_t> newest_fix_ns_;
  AlignmentWindowCounts counts_;
};

/// Covariance on the map of a point fixed to the camera, `since_m` after the end of the aligned path:
/// `position_covariance`, which includes the drift of that path, and the drift since, a random walk (see
/// AlignmentConfig).
[[nodiscard]] Eigen::Matrix3d live_covariance(const Alignment& alignment, const Eigen::Vector3d& map_m,
                                              double path_drift, double since_m);

}  // namespace kinetrace::geo

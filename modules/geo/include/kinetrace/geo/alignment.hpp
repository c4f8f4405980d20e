// Alignment of the camera's path with the map: a rigid transform onto a reference, with covariance.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include <Eigen/Core>

#include "kinetrace/core/result.hpp"
#include "kinetrace/core/se3.hpp"
#include "kinetrace/geo/reference.hpp"

namespace kinetrace::geo {

/// A pose of the left camera, x right, y down, z forward.
struct PathPose {
  std::int64_t time_ns = 0;
  Se3 T_world_cam;
};

/// Limit of plausible distances from the start of a path on Earth.
inline constexpr double kMaxPosition_m = 1e7;

enum class Freedom : std::uint8_t {
  kYaw = 4,       ///< Heading and position; the camera is assumed to be level (no roll, no pitch) in the world's axes.
  kRotation = 6,  ///< Whole rotation and position.
};

struct AlignmentConfig {
  Freedom freedom = Freedom::kRotation;
  Eigen::Vector3d lever_arm_m = Eigen::Vector3d::Zero();  ///< Of the antenna, in the left camera's axes.
  double time_offset_s = 0.0;       ///< Camera's clock minus the reference's: centre of the search.
  double max_time_offset_s = 10.0;  ///< Half width of the search; 0: the offset is known.
  /// Standard error of the path, relative to the distance travelled; the covariance includes it besides the reference's
  /// noise. Stereo odometry reaches 0.02 % rendered, 0.2 to 0.4 % in the field.
  double path_drift = 0.002;
  /// No interpolation across longer gaps: an accelerating vehicle (3 m/s2) is off a straight line by 0.1 m then.
  double max_pose_gap_s = 0.5;
  /// Larger sigmas are refused: at 30 m from the path, this is an error of a metre.
  double max_rotation_sigma_rad = 2.0 * 0.017453292519943295;
  bool roll_matters = true;  ///< False: the rotation about the direction of a straight path may remain unknown.
};

/// Unmatched: outside the path's time, or in a gap of it.
enum class FixUse : std::uint8_t { kUnmatched, kOutlier, kInlier };

enum class Verdict : std::uint8_t { kAligned, kRefused };

/// Result of an alignment.
struct Alignment {
  Verdict verdict = Verdict::kRefused;
  std::string reason;  ///< Of a refusal, with its remedy; one line.

  Se3 T_map_world;                                     ///< Map: east, north, up of the reference's frame.
  Eigen::Vector3d center_m = Eigen::Vector3d::Zero();  ///< Middle of the path on the map.
  /// Of the rotation about the map's axes (rad) and of the path's middle (m). The rotation's effect grows with the
  /// distance from there, see `position_covariance`.
  Matrix6d covariance = Matrix6d::Zero();
  double time_offset_s = 0.0;  ///< Camera's clock minus the reference's.
  double time_offset_sigma_s = 0.0;

  std::int64_t fixes = 0;    ///< During the camera's path.
  std::int64_t inliers = 0;  ///< Of these.
  std::int64_t unmatched = 0;
  std::vector<FixUse> use;  ///< By fix.
  /// Factor for the fixes' own standard deviations (east, north, up), from the residuals.
  Eigen::Vector3d sigma_factor = Eigen::Vector3d::Ones();
  double horizontal_noise_m = 0.0;  ///< Median of the fixes' standard deviations, scaled by the residuals.
  double vertical_noise_m = 0.0;
  double correlation = 1.0;  ///< Autocorrelation time: this many neighbouring fixes count as one.
  double scale = 1.0;  ///< Ratio of the path's lengths by the reference and by the camera: a check only, not applied.
  double scale_sigma = 0.0;
  double path_m = 0.0;  ///< Length of the camera's path.
};

/// Covariance of a fixed point of the world, from the alignment alone; in the map frame.
[[nodiscard]] Eigen::Matrix3d position_covariance(const Alignment& alignment, const Eigen::Vector3d& map_m);

/// Least squares of the reference's fixes against the camera's path with the lever arm; T_map_world and the time offset
/// are estimated together, scale stays metric. Start: graduated non-convexity (Yang et al., RA-L 2020) with Horn's
/// closed form (Arun et al., PAMI 1987) at every time offset of the search; then Gauss-Newton with chi-square gates
/// (0.1 % of good fixes) and noise from the residuals' median. Covariance: the residuals' autocorrelation (Geyer, Stat.
/// Sci. 1992) and a random walk of the path. A path or reference that does not determine the transform is no error: it
/// is refused, with the reason. Errors: kInvalidArgument (settings out of range, poses not in order of time or beyond
/// kMaxPosition_m).
[[nodiscard]] Result<Alignment> align(std::span<const PathPose> path, std::span<const Fix> fixes,
                                      const AlignmentConfig& config);

}  // namespace kinetrace::geo

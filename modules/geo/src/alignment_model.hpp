// The antenna's path over time, and matches of fixes with it.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "kinetrace/geo/alignment.hpp"

namespace kinetrace::geo {

/// A point of the antenna's path.
struct PathPoint {
  Eigen::Vector3d world_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();
  double distance_m = 0.0;  ///< Travelled since the start.
};

/// The antenna's path in the world: the camera's with the lever arm, linearly interpolated between poses.
class AntennaPath {
 public:
  /// Poses in order of time, at least two.
  AntennaPath(std::span<const PathPose> poses, const AlignmentConfig& config);

  /// Its position; none outside of the path and in its gaps.
  [[nodiscard]] std::optional<PathPoint> at(std::int64_t time_ns) const;
  [[nodiscard]] double length_m() const noexcept { return distances_m_.back(); }
  [[nodiscard]] std::int64_t begin_ns() const noexcept { return times_ns_.front(); }
  [[nodiscard]] std::int64_t end_ns() const noexcept { return times_ns_.back(); }

 private:
  std::vector<std::int64_t> times_ns_;
  std::vector<Eigen::Vector3d> points_m_;
  std::vector<double> distances_m_;
  std::int64_t max_gap_ns_;
};

/// A fix and the point of the path at its time.
struct Match {
  std::size_t fix = 0;
  PathPoint point;
  Eigen::Vector3d enu_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d sigma_m = Eigen::Vector3d::Ones();
};

/// Those of `fixes` (every `stride`-th) within the path's time.
[[nodiscard]] std::vector<Match> match(const AntennaPath& path, std::span<const Fix> fixes, double time_offset_s,
                                       std::size_t stride = 1);

/// From the world's axes (x right, y down, z forward) to those of a level camera on the map, facing north.
[[nodiscard]] Eigen::Matrix3d level_rotation();

/// T_map_world with the least weighted squares from points to fixes (Arun et al., PAMI 1987; about the vertical alone,
/// the same in the plane). At least one weight is positive.
[[nodiscard]] Se3 closed_form(std::span<const Match> matches, std::span<const double> weights, Freedom freedom);

}  // namespace kinetrace::geo

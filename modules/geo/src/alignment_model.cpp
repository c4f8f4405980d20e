#include "alignment_model.hpp"

#include <algorithm>
#include <cmath>

namespace kinetrace::geo {

AntennaPath::AntennaPath(std::span<const PathPose> poses, const AlignmentConfig& config)
    : max_gap_ns_(std::llround(config.max_pose_gap_s * 1e9)) {
  double distance_m = 0.0;
  for (const PathPose& pose : poses) {
    const Eigen::Vector3d point = pose.T_world_cam * config.lever_arm_m;
    distance_m += points_m_.empty() ? 0.0 : (point - points_m_.back()).norm();
    times_ns_.push_back(pose.time_ns);
    points_m_.push_back(point);
    distances_m_.push_back(distance_m);
  }
}

std::optional<PathPoint> AntennaPath::at(std::int64_t time_ns) const {
  const auto after = std::lower_bound(times_ns_.begin() + 1, times_ns_.end(), time_ns);
  if (time_ns < times_ns_.front() || after == times_ns_.end() || *after - *(after - 1) > max_gap_ns_) {
    return std::nullopt;
  }
  const auto i = static_cast<std::size_t>(after - times_ns_.begin());
  const double step_s = static_cast<double>(times_ns_[i] - times_ns_[i - 1]) * 1e-9;
  const double share = static_cast<double>(time_ns - times_ns_[i - 1]) * 1e-9 / step_s;
  const Eigen::Vector3d step_m = points_m_[i] - points_m_[i - 1];
  return PathPoint{points_m_[i - 1] + share * step_m, step_m / step_s,
                   distances_m_[i - 1] + share * (distances_m_[i] - distances_m_[i - 1])};
}

std::vector<Match> match(const AntennaPath& path, std::span<const Fix> fixes, double time_offset_s,
                         std::size_t stride) {
  const std::int64_t offset_ns = std::llround(time_offset_s * 1e9);
  std::vector<Match> matches;
  for (std::size_t i = 0; i < fixes.size(); i += stride) {
    if (const auto point = path.at(fixes[i].time_ns + offset_ns)) {
      matches.push_back({i, *point, fixes[i].enu_m, fixes[i].sigma_m});
    }
  }
  return matches;
}

Eigen::Matrix3d level_rotation() {
  Eigen::Matrix3d R_map_world;
  R_map_world << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  return R_map_world;
}

Se3 closed_form(std::span<const Match> matches, std::span<const double> weights, Freedom freedom) {
  double sum = 0.0;
  Eigen::Vector3d from = Eigen::Vector3d::Zero();
  Eigen::Vector3d to = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < matches.size(); ++i) {
    sum += weights[i];
    from += weights[i] * matches[i].point.world_m;
    to += weights[i] * matches[i].enu_m;
  }
  from /= sum;
  to /= sum;
  // Relative to the level frame, so that undetermined rotations stay level.
  const Eigen::Matrix3d level = level_rotation();
  Eigen::Matrix3d cross = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < matches.size(); ++i) {
    cross += weights[i] * (matches[i].enu_m - to) * (level * (matches[i].point.world_m - from)).transpose();
  }
  Eigen::Matrix3d R_map_level = Eigen::Matrix3d::Identity();
  if (freedom == Freedom::kYaw) {
    const double yaw_rad = std::atan2(cross(1, 0) - cross(0, 1), cross(0, 0) + cross(1, 1));
    R_map_level = so3_exp(yaw_rad * Eigen::Vector3d::UnitZ());
  } else {
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(cross, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Vector3d signs = Eigen::Vector3d::Ones();
    signs.z() = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0;
    R_map_level = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  }
  const Eigen::Matrix3d R_map_world = R_map_level * level;
  return {R_map_world, to - R_map_world * from};
}

}  // namespace kinetrace::geo

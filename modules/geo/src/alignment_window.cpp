#include "kinetrace/geo/alignment_window.hpp"

#include <algorithm>
#include <cmath>

namespace kinetrace::geo {
namespace {

double seconds_between(std::int64_t from_ns, std::int64_t to_ns) noexcept {
  return static_cast<double>(to_ns - from_ns) * 1e-9;
}

}  // namespace

AlignmentWindow::AlignmentWindow(const AlignmentWindowConfig& config) : config_(config) {
  path_.reserve(config.max_poses);
  distances_m_.reserve(config.max_poses);
  fixes_.reserve(config.max_fixes);
  fix_distances_m_.reserve(config.max_fixes);
}

Result<AlignmentWindow> AlignmentWindow::create(const AlignmentWindowConfig& config) {
  constexpr std::size_t kMin = 2;
  constexpr std::size_t kMax = 100'000;
  const bool is_valid = config.max_path_m > 0.0 && config.max_poses >= kMin && config.max_poses <= kMax &&
                        config.max_fixes >= kMin && config.max_fixes <= kMax && config.min_pose_interval_s >= 0.0 &&
                        config.min_pose_distance_m >= 0.0 && config.max_rest_s > 0.0 &&
                        config.min_fix_interval_s >= 0.0;
  if (!is_valid) {
    return fail(ErrorCode::kInvalidArgument,
                "settings of the alignment window out of range: 2 to 100000 poses and fixes, a path and a time of rest "
                "above 0, no negative distance or interval");
  }
  return AlignmentWindow(config);
}

void AlignmentWindow::clear() noexcept {
  counts_.restarts += path_.empty() ? 0 : 1;
  path_.clear();
  distances_m_.clear();
  fixes_.clear();
  fix_distances_m_.clear();
  newest_pose_ns_.reset();
  newest_fix_ns_.reset();
}

void AlignmentWindow::remove_oldest_fix() {
  fixes_.erase(fixes_.begin());
  fix_distances_m_.erase(fix_distances_m_.begin());
  ++counts_.fixes_before_window;
}

void AlignmentWindow::remove_oldest_pose() {
  path_.erase(path_.begin());
  distances_m_.erase(distances_m_.begin());
  while (!fixes_.empty() && fix_distances_m_.front() < distances_m_.front()) {
    remove_oldest_fix();
  }
}

void AlignmentWindow::add(const PathPose& pose) {
  if (newest_pose_ns_ && pose.time_ns <= *newest_pose_ns_) {
    clear();
  }
  newest_pose_ns_ = pose.time_ns;
  if (path_.empty()) {
    path_.push_back(pose);
    distances_m_.push_back(0.0);
    return;
  }
  const double step_m = (pose.T_world_cam.translation - path_.back().T_world_cam.translation).norm();
  if (seconds_between(path_.back().time_ns, pose.time_ns) < config_.min_pose_interval_s ||
      step_m < config_.min_pose_distance_m) {
    return;
  }
  const double distance_m = distances_m_.back() + step_m;
  while (path_.size() == config_.max_poses ||
         (path_.size() > 1 && distance_m - distances_m_.front() > config_.max_path_m)) {
    remove_oldest_pose();
  }
  path_.push_back(pose);
  distances_m_.push_back(distance_m);
}

bool AlignmentWindow::is_at_rest() const noexcept {
  return path_.empty() || seconds_between(path_.back().time_ns, *newest_pose_ns_) > config_.max_rest_s;
}

void AlignmentWindow::add(const Fix& fix) {
  ++counts_.fixes;
  if (newest_fix_ns_ && fix.time_ns <= *newest_fix_ns_) {
    ++counts_.fixes_out_of_order;
    return;
  }
  if (is_at_rest()) {
    ++counts_.fixes_at_rest;
    return;
  }
  if (newest_fix_ns_ && seconds_between(*newest_fix_ns_, fix.time_ns) < config_.min_fix_interval_s) {
    return;
  }
  newest_fix_ns_ = fix.time_ns;
  if (fixes_.size() == config_.max_fixes) {
    remove_oldest_fix();
  }
  fixes_.push_back(fix);
  fix_distances_m_.push_back(distances_m_.back());
}

Eigen::Matrix3d live_covariance(const Alignment& alignment, const Eigen::Vector3d& map_m, double path_drift,
                                double since_m) {
  const double drift_m2 = path_drift * path_drift * alignment.path_m * std::max(since_m, 0.0);
  return position_covariance(alignment, map_m) + drift_m2 * Eigen::Matrix3d::Identity();
}

}  // namespace kinetrace::geo

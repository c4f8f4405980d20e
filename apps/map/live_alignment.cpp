#include "live_alignment.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

namespace kinetrace::map {

void LiveAlignment::leave_world() noexcept {
  newest_.reset();
  aligned_.reset();
  latency_ns_.reset();
}

void LiveAlignment::lose_camera() noexcept {
  window_.clear();
  leave_world();
}

void LiveAlignment::add_pose(std::int64_t frame_index, std::int64_t timestamp_ns, std::int64_t handed_over_ns,
                             const Se3& T_world_cam) {
  if (!(T_world_cam.translation.norm() <= geo::kMaxPosition_m)) {
    return;
  }
  if (newest_frame_ && frame_index <= *newest_frame_) {
    lose_camera();
  }
  newest_frame_ = frame_index;
  const std::int64_t restarts = window_.counts().restarts;
  window_.add(geo::PathPose{timestamp_ns, T_world_cam});
  if (window_.counts().restarts != restarts) {
    leave_world();
  }
  has_poses_ = true;
  newest_place_m_ = T_world_cam.translation;
  const std::int64_t latency_ns = handed_over_ns - timestamp_ns;
  latency_ns_ = std::min(latency_ns, latency_ns_.value_or(latency_ns));
}

void LiveAlignment::count_without_fix() noexcept {
  ++counts_.records;
  ++counts_.without_fix;
}

Status LiveAlignment::add_fix(std::int64_t time_ns, const geo::Geodetic& place, const Eigen::Vector3d& sigma_m) {
  ++counts_.records;
  constexpr double kMaxSigma_m = 1e6;
  if (!geo::is_valid(place) || !((sigma_m.array() >= 0.0) && (sigma_m.array() <= kMaxSigma_m)).all()) {
    ++counts_.malformed;
    return {};
  }
  if (!frame_) {
    frame_ = geo::LocalFrame::at(place).value();
  }
  if (Status near = origin_is_checked_ ? Status{} : geo::check_origin(*frame_, place); !near) {
    return near;
  }
  origin_is_checked_ = true;
  constexpr double kMinSigma_m = 1e-3;
  window_.add(geo::Fix{time_ns, frame_->to_enu(place), sigma_m.cwiseMax(kMinSigma_m)});
  return {};
}

bool LiveAlignment::has_new_fixes() const noexcept {
  return window_.path().size() > 1 && !window_.fixes().empty() && window_.counts().fixes > tried_fixes_;
}

void LiveAlignment::fill(AlignmentTask& task) {
  task.path.assign(window_.path().begin(), window_.path().end());
  task.fixes.assign(window_.fixes().begin(), window_.fixes().end());
  task.config = config_;
  if (!offset_is_given_) {
    task.config.time_offset_s = -static_cast<double>(*latency_ns_) * 1e-9;
  }
  task.end_m = window_.distance_m();
  task.restarts = window_.counts().restarts;
  tried_fixes_ = window_.counts().fixes;
}

void LiveAlignment::accept(const AlignmentTask& task, const geo::Alignment& alignment) {
  if (task.restarts != window_.counts().restarts) {
    return;
  }
  newest_ = alignment;
  if (alignment.verdict == geo::Verdict::kAligned) {
    aligned_ = alignment;
    aligned_end_m_ = task.end_m;
  }
}

MapPlace LiveAlignment::place(const Eigen::Vector3d& world_m) const {
  const Eigen::Vector3d map_m = aligned_->T_map_world * world_m;
  return {frame_->to_geodetic(map_m),
          geo::live_covariance(*aligned_, map_m, config_.path_drift, window_.distance_m() - aligned_end_m_)};
}

double LiveAlignment::horizontal_sigma_m() const {
  const Eigen::Matrix2d covariance = place(newest_place_m_).covariance_m2.topLeftCorner<2, 2>();
  return std::sqrt(Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(covariance).eigenvalues()[1]);
}

std::string LiveAlignment::reason() const {
  if (!has_poses_) {
    return "no pose of the camera has come yet";
  }
  if (!has_fixes()) {
    return "no fix has come yet";
  }
  return newest_ ? newest_->reason : "the path has just begun";
}

geo::ReferenceCounts LiveAlignment::counts() const noexcept {
  geo::ReferenceCounts counts = counts_;
  counts.out_of_order = window_.counts().fixes_out_of_order;
  return counts;
}

}  // namespace kinetrace::map

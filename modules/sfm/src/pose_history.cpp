#include "kinetrace/sfm/pose_history.hpp"

#include <algorithm>

namespace kinetrace::sfm {

void PoseHistory::push(const FinalisedPose& pose, std::size_t column) noexcept {
  head_ = (head_ + 1) % entries_.size();
  entries_[head_] = Entry{pose, column, Se3{}};
  size_ = std::min(size_ + 1, entries_.size());
}

FinalisedPose PoseHistory::at(std::size_t age, std::span<const Se3> T_body_cam) const noexcept {
  const Entry& e = entry(age);
  FinalisedPose pose = e.pose;
  if (e.column != kFrozen) {
    pose.T_body_cam = T_body_cam[e.column] * e.T_column_cam;
  }
  return pose;
}

void PoseHistory::update_newest(BodyStatus status, const Matrix6d& covariance, int inliers) noexcept {
  FinalisedPose& newest = entry(0).pose;
  newest.status = status;
  newest.covariance = covariance;
  newest.inliers = inliers;
}

void PoseHistory::drop_column(std::size_t column, std::span<const Se3> T_body_cam, std::size_t target_column) noexcept {
  for (std::size_t age = 0; age < size_; ++age) {
    Entry& e = entry(age);
    if (e.column == column) {
      if (target_column == kFrozen) {
        freeze(e, T_body_cam);
      } else {
        e.T_column_cam = T_body_cam[target_column].inverse() * T_body_cam[column] * e.T_column_cam;
        e.column = target_column;
      }
    }
    if (e.column != kFrozen && e.column > column) {
      --e.column;
    }
  }
}

void PoseHistory::freeze(std::span<const Se3> T_body_cam) noexcept {
  for (std::size_t age = 0; age < size_; ++age) {
    freeze(entry(age), T_body_cam);
  }
}

void PoseHistory::freeze(Entry& e, std::span<const Se3> T_body_cam) noexcept {
  if (e.column != kFrozen) {
    e.pose.T_body_cam = T_body_cam[e.column] * e.T_column_cam;
    e.column = kFrozen;
  }
}

}  // namespace kinetrace::sfm

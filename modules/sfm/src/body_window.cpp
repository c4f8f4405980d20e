// The window of a body: selection of frames, and of the poses that refinement may move.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "columns.hpp"
#include "kinetrace/core/quantiles.hpp"
#include "kinetrace/sfm/body_reconstruction.hpp"

namespace kinetrace::sfm {
namespace {

/// The anchor observes at least this fraction of the points of the best column. A pose from few points is less certain
/// than its successors: fixed, it would bend the window.
constexpr double kAnchorShare = 0.8;

/// At least half of the poses are fixed. They were refined often, with observations that have partly left the window;
/// the remaining ones alone would make them worse (and cost time).
constexpr std::size_t kFixedPart = 2;

/// Merged observations count as at most this many: tracking errors are correlated while little moves, so they do not
/// average out without limit. A far smaller bound would make the map follow the latest frames, and drift with them.
constexpr float kMaxMergedObservations = 16.F;

}  // namespace

bool BodyReconstruction::newest_is_redundant() const {
  if (used_columns_ < 2) {
    return false;
  }
  const std::size_t newest = newest_column();
  std::size_t seen = 0;
  std::size_t shared = 0;
  for (std::size_t row = 0; row < map_.size(); ++row) {
    if ((map_.state(row).seen & bit(newest)) == 0) {
      continue;
    }
    ++seen;
    // Merged observations depend on poses of dropped frames, so they do not count.
    if ((map_.state(row).observed & bit(newest - 1)) != 0) {
      const std::span<const BundleObservation> o = map_.observations(row);
      scratch_[shared++] =
          std::hypot(o[newest].u_left_px - o[newest - 1].u_left_px, o[newest].v_px - o[newest - 1].v_px);
    }
  }
  if (shared == 0 || static_cast<double>(shared) < config_.keyframe_overlap * static_cast<double>(seen)) {
    return false;
  }
  return double{median(scratch_.first(shared))} < config_.keyframe_motion_px;
}

void BodyReconstruction::drop_column(std::size_t column, std::size_t target_column) {
  history_.drop_column(column, poses_, target_column);
  map_.remove_column(column);
  const auto close_gap = [column](auto columns) {
    const auto gap = columns.begin() + static_cast<std::ptrdiff_t>(column);
    std::copy(gap + 1, columns.end(), gap);
  };
  close_gap(poses_);
  close_gap(drifts_);
  close_gap(attitudes_);
}

void BodyReconstruction::merge_into_keyframe() {
  const std::size_t newest = newest_column();
  const Se3 T_newest_body = poses_[newest].inverse();
  const Se3 T_keyframe_body = poses_[newest - 1].inverse();
  const float max_inverse_sigma = std::sqrt(kMaxMergedObservations) * inverse_sigma();
  for (std::size_t row = 0; row < map_.size(); ++row) {
    const PointState& state = map_.state(row);
    if (!state.positioned || (state.seen & bit(newest)) == 0) {
      continue;
    }
    const Eigen::Vector3d p_newest = T_newest_body * map_.point(row).position_m;
    const Eigen::Vector3d p_keyframe = T_keyframe_body * map_.point(row).position_m;
    if (p_newest.z() < kMinProjectionDepth_m || p_keyframe.z() < kMinProjectionDepth_m) {
      continue;
    }
    const Eigen::Vector3f shift_px = (geometry_.project(p_keyframe) - geometry_.project(p_newest)).cast<float>();
    BundleObservation moved = map_.observations(row)[newest];
    moved.u_left_px += shift_px.x();
    moved.v_px += shift_px.y();
    moved.u_right_px += shift_px.z();
    map_.merge(row, newest - 1, moved, max_inverse_sigma);
  }
}

void BodyReconstruction::advance_window() {
  const std::size_t newest = newest_column();
  if (newest_redundant_) {
    merge_into_keyframe();
    drop_column(newest, newest - 1);
    return;
  }
  drop_column(0, PoseHistory::kFrozen);
  used_columns_ = std::min(used_columns_ + 1, poses_.size());
}

std::size_t BodyReconstruction::find_anchor() const {
  std::array<int, kMaxWindowFrames> points_of{};
  for (std::size_t row = 0; row < map_.size(); ++row) {
    for (std::uint32_t rest = map_.point(row).frames; rest != 0; rest &= rest - 1) {
      ++points_of[static_cast<std::size_t>(std::countr_zero(rest))];
    }
  }
  const int most = *std::max_element(points_of.begin(), points_of.end());
  const int enough = std::max(config_.min_inliers, static_cast<int>(kAnchorShare * most));
  const std::size_t fixed = std::max(poses_.size() / kFixedPart, std::size_t{1});
  std::size_t anchor = std::max(poses_.size() - used_columns_, fixed - 1);
  while (anchor < newest_column() && points_of[anchor] < enough) {
    ++anchor;
  }
  return anchor;
}

TurnPrior BodyReconstruction::expected_turn(std::size_t column) const {
  const bool has_predecessor = column > poses_.size() - used_columns_;
  if (!has_predecessor || !attitudes_[column - 1].known || !attitudes_[column].known) {
    return {};
  }
  const CameraAttitude& before = attitudes_[column - 1];
  const CameraAttitude& now = attitudes_[column];
  const double sigma_rad = config_.turn_rate_radps * 1e-9 * static_cast<double>(now.timestamp_ns - before.timestamp_ns);
  return {before.R_world_cam.transpose() * now.R_world_cam, sigma_rad > 0.0 ? 1.0 / sigma_rad : 0.0};
}

BundleWindow BodyReconstruction::window() {
  for (std::size_t row = 0; row < map_.size(); ++row) {
    const PointState& state = map_.state(row);
    // A single observation places a point but has no information on poses.
    map_.point(row).frames = state.positioned && std::popcount(state.seen) >= 2 ? state.seen : 0U;
  }
  for (std::size_t column = 0; column < turns_.size(); ++column) {
    turns_[column] = expected_turn(column);
  }
  anchor_column_ = in_window_ ? find_anchor() : newest_column();
  return {.geometry = geometry_,
          .T_body_cam = poses_,
          .fixed_frames = first_bits(anchor_column_ + 1),
          .points = map_.points(),
          .observations = map_.table(),
          .turns = config_.turn_rate_radps > 0.0 ? turns_ : std::span<TurnPrior>{}};
}

}  // namespace kinetrace::sfm

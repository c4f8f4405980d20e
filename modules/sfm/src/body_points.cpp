// The points of a body: adding observations, finding positions, removing wrong points.
#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <optional>

#include "columns.hpp"
#include "kinetrace/sfm/body_reconstruction.hpp"
#include "kinetrace/sfm/triangulation.hpp"

namespace kinetrace::sfm {
namespace {

// Disagreements in a row after which a feature's point is dropped. The point may be wrong, from one mismatch, so its
// feature starts once more; after one more disagreement it is not used again.
constexpr int kMaxDisagreements = 2;

}  // namespace

void BodyReconstruction::add_observations(const FeatureFrame& frame, std::uint8_t label) {
  std::size_t newcomers = 0;
  for (const Feature& feature : frame.features) {
    if (feature.body != label || !classify_point(feature)) {
      continue;
    }
    const std::size_t row = map_.find(feature);
    if (row == PointMap::kNone) {
      ++newcomers;
    } else if (verdict_[feature.slot] != Verdict::kOutlier) {
      map_.observe(row, newest_column(), observation_of(feature));
    }
  }
  evict_for(newcomers);
  for (const Feature& feature : frame.features) {
    const bool newcomer = feature.body == label && map_.find(feature) == PointMap::kNone;
    if (!newcomer || is_suspect(feature) || verdict_[feature.slot] == Verdict::kOutlier) {
      continue;
    }
    const std::size_t row = map_.create(feature);
    if (row == PointMap::kNone) {
      ++counters_.points_dropped;
      continue;
    }
    map_.observe(row, newest_column(), observation_of(feature));
  }
}

BundleObservation BodyReconstruction::observation_of(const Feature& feature) const {
  return {feature.left_px.x(), feature.v_px, feature.u_right_px, inverse_sigma()};
}

bool BodyReconstruction::is_suspect(const Feature& feature) const {
  return disagreeing_id_[feature.slot] == feature.id && disagreements_[feature.slot] > kMaxDisagreements;
}

bool BodyReconstruction::classify_point(const Feature& feature) {
  const std::size_t slot = feature.slot;
  if (disagreeing_id_[slot] != feature.id) {
    disagreeing_id_[slot] = feature.id;
    disagreements_[slot] = 0;
  }
  if (verdict_[slot] == Verdict::kInlier) {
    disagreements_[slot] = 0;
  }
  const std::size_t row = map_.find(feature);
  const bool disagrees = verdict_[slot] == Verdict::kOutlier || (row == PointMap::kNone && is_suspect(feature));
  if (disagrees) {
    disagree(slot);
  }
  if (disagrees && disagreements_[slot] >= config_.reject_after_frames) {
    static_cast<void>(rejected_.push_back(feature.slot));
  }
  if (row != PointMap::kNone && disagreements_[slot] >= kMaxDisagreements) {
    retire(row);
    map_.remove(row);
    ++counters_.points_culled;
    verdict_[slot] = Verdict::kUnknown;
  }
  return !is_suspect(feature);
}

void BodyReconstruction::disagree(std::size_t slot) {
  disagreements_[slot] = static_cast<std::uint8_t>(std::min(disagreements_[slot] + 1, 255));
}

void BodyReconstruction::evict_for(std::size_t newcomers) {
  const std::uint32_t newest = bit(newest_column());
  // By the column of the last observation, oldest first; step 0 takes rows without any.
  for (int age = 0; age <= static_cast<int>(newest_column()); ++age) {
    for (std::size_t row = map_.size(); row-- > 0;) {
      if (map_.size() + newcomers <= map_.capacity()) {
        return;
      }
      const std::uint32_t seen = map_.state(row).seen;
      if ((seen & newest) == 0 && static_cast<int>(std::bit_width(seen)) == age) {
        retire(row);
        map_.remove(row);
        ++counters_.points_evicted;
      }
    }
  }
}

BodyReconstruction::ColumnPoses BodyReconstruction::invert_poses() const {
  ColumnPoses T_cam_body;
  std::transform(poses_.begin(), poses_.end(), T_cam_body.begin(), [](const Se3& T) { return T.inverse(); });
  return T_cam_body;
}

double BodyReconstruction::observation_chi2(const Se3& T_cam_body, const Eigen::Vector3d& p_body,
                                            const BundleObservation& o) const {
  return reprojection_chi2(geometry_, T_cam_body, {p_body, o.u_left_px, o.v_px, o.u_right_px}, noise_.sigma_px());
}

void BodyReconstruction::position_new_points() {
  const ColumnPoses T_cam_body = invert_poses();
  const double min_parallax_rad = config_.min_parallax_deg * std::numbers::pi / 180.0;
  // Parallax of stereo at the smallest accepted disparity, so that one good pair is enough.
  const double stereo_parallax_rad = 0.9 * config_.min_disparity_px / geometry_.fx_px;
  const double gate2 = config_.gate_sigma * config_.gate_sigma;
  for (std::size_t row = map_.size(); row-- > 0;) {
    PointState& state = map_.state(row);
    if (state.positioned) {
      continue;
    }
    if ((state.seen & bit(newest_column())) == 0) {
      map_.remove(row);  // Its feature ended before it was triangulated.
      continue;
    }
    const BundleObservation& o = map_.observations(row)[newest_column()];
    const bool stereo = o.u_left_px - o.u_right_px >= static_cast<float>(config_.min_disparity_px);  // false for NaN
    const std::optional<Eigen::Vector3d> position = triangulate(geometry_, poses_, map_.observations(row), state.seen,
                                                                stereo ? stereo_parallax_rad : min_parallax_rad);
    if (!position) {
      continue;
    }
    bool agrees = true;
    for (std::uint32_t rest = state.seen; rest != 0 && agrees; rest &= rest - 1) {
      const auto k = static_cast<std::size_t>(std::countr_zero(rest));
      agrees = observation_chi2(T_cam_body[k], *position, map_.observations(row)[k]) < gate2;
    }
    if (agrees) {
      state.positioned = true;
      map_.point(row).position_m = *position;
      ++counters_.points_created;
    } else if (std::popcount(state.seen) > kMaxDisagreements) {
      // Older observations are of another point; restart from this frame.
      state.seen = bit(newest_column());
      state.observed = state.seen;
      state.observations = 1;
    }
  }
}

void BodyReconstruction::reposition_newcomers() {
  const bool single_frame = poses_.size() == 1;  // All points from this frame's stereo alone.
  for (std::size_t row = 0; row < map_.size(); ++row) {
    const PointState& state = map_.state(row);
    if (!state.positioned || state.seen == 0 || (state.observations != 1 && !single_frame)) {
      continue;
    }
    const auto k = static_cast<std::size_t>(std::countr_zero(state.seen));
    const BundleObservation& o = map_.observations(row)[k];
    const double disparity_px = double{o.u_left_px} - double{o.u_right_px};
    if (disparity_px >= config_.min_disparity_px) {
      map_.point(row).position_m = poses_[k] * geometry_.triangulate(double{o.u_left_px}, double{o.v_px}, disparity_px);
    }
  }
}

void BodyReconstruction::assess(std::size_t row, const ColumnPoses& T_cam_body) {
  PointState& state = map_.state(row);
  const double gate2 = config_.gate_sigma * config_.gate_sigma;
  double sum = 0.0;
  int count = 0;
  for (std::uint32_t rest = state.seen; rest != 0; rest &= rest - 1) {
    const auto k = static_cast<std::size_t>(std::countr_zero(rest));
    const double chi2 = observation_chi2(T_cam_body[k], map_.point(row).position_m, map_.observations(row)[k]);
    if (chi2 > gate2) {
      map_.forget(row, k);
      if (k == newest_column()) {
        disagree(state.slot);
      }
    } else {
      sum += chi2;
      ++count;
    }
  }
  state.error_px = count > 0 ? static_cast<float>(noise_.sigma_px() * std::sqrt(sum / count)) : 0.F;
}

void BodyReconstruction::cull_points() {
  const ColumnPoses T_cam_body = invert_poses();
  for (std::size_t row = map_.size(); row-- > 0;) {
    if (!map_.state(row).positioned) {
      continue;
    }
    const bool seen_before = map_.state(row).seen != 0;
    assess(row, T_cam_body);
    if (map_.state(row).seen == 0) {
      if (seen_before) {
        ++counters_.points_culled;
      } else {
        retire(row);
      }
      map_.remove(row);
    }
  }
}

void BodyReconstruction::retire(std::size_t row) {
  const PointState& state = map_.state(row);
  if (state.positioned && state.observations >= 2) {
    static_cast<void>(retired_.push_back({.id = state.id,
                                          .position_m = map_.point(row).position_m.cast<float>(),
                                          .reprojection_error_px = state.error_px,
                                          .observations = state.observations,
                                          .intensity = state.intensity}));
  }
}

}  // namespace kinetrace::sfm

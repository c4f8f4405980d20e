#include "camera/rig_calibrator.hpp"

#include <algorithm>
#include <cmath>

#include "kinetrace/core/quantiles.hpp"

namespace kinetrace::pipeline {
namespace {

constexpr double kMaxDisparityChange_px = 0.7;  // Of all disparities: a path must not mix both.

bool is_rig_observation(const Feature& feature) {
  return feature.body == kBackgroundLabel && feature.has_right();
}

/// A pose that most tracked features contradict does not select inliers: with a calibration that is far off, a few
/// features agree on any pose.
bool is_pose_supported(const FeatureFrame& frame, const sfm::BodyReconstruction& background) {
  constexpr int kMinTracked_frames = 2;
  std::size_t tracked = 0;
  std::size_t agreed = 0;
  for (const Feature& feature : frame.features) {
    if (is_rig_observation(feature) && feature.age_frames >= kMinTracked_frames) {
      ++tracked;
      agreed += background.agreed(feature) ? 1 : 0;
    }
  }
  return 2 * agreed >= tracked;
}

double median_disparity_px(std::span<const rig::RigObservation> observations, std::span<float> scratch_px) {
  if (observations.empty()) {
    return 0.0;
  }
  const std::span<float> disparities = scratch_px.first(observations.size());
  std::transform(observations.begin(), observations.end(), disparities.begin(),
                 [](const rig::RigObservation& o) { return o.left_px.x() - o.right_px.x(); });
  return double{median(disparities)};
}

}  // namespace

std::size_t RigCalibrator::required_bytes(const PipelineConfig& config) {
  if (config.calibration.mode == rig::RefineMode::kOff) {
    return 0;
  }
  return rig::RigRefiner::required_bytes(config.calibration) + measure_bytes([&](Arena& arena) {
           const auto features = static_cast<std::size_t>(config.features.max_features);
           static_cast<void>(FixedVector<rig::RigObservation>(arena, features));
           static_cast<void>(arena.take<float>(features));
         });
}

Result<RigCalibrator> RigCalibrator::create(const PipelineConfig& config, const StereoGeometry& geometry,
                                            Arena& arena) {
  RigCalibrator calibrator;
  calibrator.geometry_ = geometry;
  if (config.calibration.mode == rig::RefineMode::kOff) {
    return calibrator;
  }
  Result<rig::RigRefiner> refiner = rig::RigRefiner::create(config.calibration, geometry, arena);
  if (!refiner) {
    return Unexpected(refiner.error());
  }
  calibrator.refiner_ = *refiner;
  const auto features = static_cast<std::size_t>(config.features.max_features);
  calibrator.observations_ = FixedVector<rig::RigObservation>(arena, features);
  calibrator.scratch_px_ = arena.take<float>(features);
  calibrator.corrects_ = config.calibration.mode == rig::RefineMode::kOn;
  return calibrator;
}

void RigCalibrator::begin_frame(std::int64_t timestamp_ns) {
  change_.reset();
  must_restart_ = false;
  must_restart_paths_ = false;
  if (!refiner_) {
    return;
  }
  refiner_->begin_frame(timestamp_ns);
  must_restart_ = refiner_->must_restart();
  if (const auto revision = refiner_->revision()) {
    change_.emplace(geometry_, revision->before, revision->now);
    const double difference_rad = revision->now.disparity_error_rad() - revision->before.disparity_error_rad();
    must_restart_paths_ = std::abs(difference_rad) * geometry_.fx_px > kMaxDisparityChange_px;
  }
}

features::RigAdjustment RigCalibrator::adjustment() const {
  return corrects_ ? features::RigAdjustment{refiner_->correction(), true, change()} : features::RigAdjustment{};
}

void RigCalibrator::add_uncertainty(CameraState& camera) const {
  const RigEstimate known = estimate();
  const double remaining_rad = known.correction.disparity_error_rad() - known.applied.disparity_error_rad();
  const bool is_verified = known.verdict == RigVerdict::kHolds;
  camera.disparity_sigma_px =
      is_verified ? 0.0 : std::hypot(remaining_rad, known.disparity_sigma_rad) * geometry_.fx_px;
  camera.background_disparity_px = background_disparity_px_;
}

void RigCalibrator::observe(const FeatureFrame& frame, const CameraTracker& camera, bool is_cut) {
  if (!refiner_) {
    return;
  }
  if (is_cut || !camera.tracked()) {
    refiner_->forget_scene();
    return;
  }
  const bool selects_inliers = is_pose_supported(frame, camera.background());
  observations_.clear();
  for (const Feature& feature : frame.features) {
    if (is_rig_observation(feature) && (!selects_inliers || camera.background().agreed(feature))) {
      const float right_row_px = 2.F * feature.v_px - feature.left_px.y();
      static_cast<void>(
          observations_.push_back({feature.id, feature.slot, feature.left_px, {feature.u_right_px, right_row_px}}));
    }
  }
  background_disparity_px_ = median_disparity_px(observations_.span(), scratch_px_);
  refiner_->observe(observations_.span(), camera.background().estimate().T_body_cam);
}

}  // namespace kinetrace::pipeline

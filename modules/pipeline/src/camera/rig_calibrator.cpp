#include "camera/rig_calibrator.hpp"

namespace kinetrace::pipeline {
namespace {

bool tells_of_rig(const Feature& feature) {
  return feature.body == kBackgroundLabel && feature.has_right();
}

/// A pose that most of what has been followed disagrees with is no judge of it: where the calibration is far off, a few
/// features agree on anything.
bool pose_is_agreed(const FeatureFrame& frame, const sfm::BodyReconstruction& background) {
  constexpr int kFollowed_frames = 2;
  std::size_t followed = 0;
  std::size_t agreed = 0;
  for (const Feature& feature : frame.features) {
    if (tells_of_rig(feature) && feature.age_frames >= kFollowed_frames) {
      ++followed;
      agreed += background.agreed(feature) ? 1 : 0;
    }
  }
  return 2 * agreed >= followed;
}

}  // namespace

std::size_t RigCalibrator::required_bytes(const PipelineConfig& config) {
  if (config.calibration.mode == rig::RefineMode::kOff) {
    return 0;
  }
  return rig::RigRefiner::required_bytes(config.calibration) + measure_bytes([&](Arena& arena) {
           static_cast<void>(
               FixedVector<rig::RigObservation>(arena, static_cast<std::size_t>(config.features.max_features)));
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
  calibrator.observations_ =
      FixedVector<rig::RigObservation>(arena, static_cast<std::size_t>(config.features.max_features));
  calibrator.corrects_ = config.calibration.mode == rig::RefineMode::kOn;
  return calibrator;
}

void RigCalibrator::begin_frame(std::int64_t timestamp_ns) {
  change_.reset();
  must_restart_ = false;
  if (!refiner_) {
    return;
  }
  refiner_->begin_frame(timestamp_ns);
  must_restart_ = refiner_->must_restart();
  if (const auto revision = refiner_->revision()) {
    change_.emplace(geometry_, revision->before, revision->now);
  }
}

features::RigAdjustment RigCalibrator::adjustment() const {
  return corrects_ ? features::RigAdjustment{refiner_->correction(), true, change()} : features::RigAdjustment{};
}

void RigCalibrator::observe(const FeatureFrame& frame, const CameraTracker& camera, bool jumped) {
  if (!refiner_) {
    return;
  }
  if (jumped || !camera.tracked()) {
    refiner_->forget_scene();
    return;
  }
  const bool trusts_pose = pose_is_agreed(frame, camera.background());
  observations_.clear();
  for (const Feature& feature : frame.features) {
    if (tells_of_rig(feature) && (!trusts_pose || camera.background().agreed(feature))) {
      const float right_row_px = 2.F * feature.v_px - feature.left_px.y();
      static_cast<void>(
          observations_.push_back({feature.id, feature.slot, feature.left_px, {feature.u_right_px, right_row_px}}));
    }
  }
  refiner_->observe(observations_.span(), camera.background().estimate().T_body_cam);
}

}  // namespace kinetrace::pipeline

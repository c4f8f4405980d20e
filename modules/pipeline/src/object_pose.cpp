// The part of ObjectState that locates and restarts its reconstruction.
#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "object_state.hpp"

namespace kinetrace::pipeline {
namespace {

constexpr double kPoseGate = 36.0;            // Chi-square with six degrees of freedom.
constexpr double kMaxOutsideBox_m = 2.0;      // A point outside the box by more than this,
constexpr double kMaxOutsideBoxSigmas = 4.0;  // plus this many of stereo depth, is on another object.

}  // namespace

bool ObjectState::locate(const FeatureFrame& frame, const StereoObservation& observation, const CameraState& camera) {
  if (!is_rigid() || !body_.active()) {
    return false;
  }
  const std::optional<sfm::BodyReconstruction::Expectation> expected = expected_pose(camera);
  if (body_.locate(frame, life_.track.label(), expected ? &*expected : nullptr).status != BodyStatus::kTracked ||
      !camera.valid) {
    return false;
  }
  if (is_observed_outside_box(observation, body_.estimate().T_body_cam) ||
      (expected && !passes_innovation_gate(*expected))) {
    body_.refuse_pose();
    return false;
  }
  return true;
}

bool ObjectState::is_observed_outside_box(const StereoObservation& observation, const Se3& T_obj_cam) const {
  if (observation.agreeing < config_.stereo_only_min_features || 2 * observation.agreeing < observation.features) {
    return false;
  }
  const Eigen::Vector3d seen_cam_m = position_in_camera(geometry_, observation);
  const Eigen::Vector3d seen_obj_m = T_obj_cam * seen_cam_m;
  const Eigen::Vector3d off_m = box_.known() ? offset_from(box_.box_in_object(), seen_obj_m)
                                             : Eigen::Vector3d(seen_obj_m + identity_.to_origin_m);
  const double depth_sigma_m = geometry_.depth_sigma_m(seen_cam_m.z(), kObservedDisparitySigma_px);
  return off_m.norm() > kMaxOutsideBox_m + kMaxOutsideBoxSigmas * depth_sigma_m;
}

std::optional<sfm::BodyReconstruction::Expectation> ObjectState::expected_pose(const CameraState& camera) const {
  if (life_.status != BodyStatus::kTracked || motion_.size() < kMinPathFrames || !camera.valid) {
    return std::nullopt;
  }
  const objects::UncertainPose expected = identity_.filter.predicted(life_.timestamp_ns);
  // In the object's own axes, like the perturbation of T_obj_cam.
  Matrix6d to_object = Matrix6d::Zero();
  to_object.topLeftCorner<3, 3>() = expected.T_world_obj.rotation.transpose();
  to_object.bottomRightCorner<3, 3>() = expected.T_world_obj.rotation.transpose();
  return sfm::BodyReconstruction::Expectation{expected.T_world_obj.inverse() * camera.T_world_cam,
                                              to_object * expected.covariance * to_object.transpose()};
}

bool ObjectState::passes_innovation_gate(const sfm::BodyReconstruction::Expectation& expected) const {
  const BodyEstimate& found = body_.estimate();
  const Vector6d innovation = left_difference(expected.T_body_cam, found.T_body_cam);
  const Matrix6d innovation_covariance = expected.covariance + found.covariance;
  return innovation.dot(innovation_covariance.ldlt().solve(innovation)) <= kPoseGate;
}

void ObjectState::begin_body(const StereoObservation& observation, const CameraState& camera) {
  if (identity_.reconstructed &&
      is_observed_outside_box(observation, identity_.T_world_obj.inverse() * camera.T_world_cam)) {
    return;  // Its mask mostly lies on another object.
  }
  if (identity_.reconstructed) {
    // It begins at the predicted pose: its frame is as uncertain on the object.
    const Matrix6d axes = adjoint(Se3{identity_.T_world_obj.rotation.transpose(), Eigen::Vector3d::Zero()});
    identity_.drift_covariance = drift_covariance() + axes * life_.covariance * axes.transpose();
  } else {
    // The stereo position so far may be that of a neighbouring surface; the frame belongs on the object's points.
    frame_.change = std::max(frame_.change, FrameChange::kRefined);
    identity_.T_world_obj.translation = camera.T_world_cam * position_in_camera(geometry_, observation);
    identity_.to_origin_m.setZero();
    identity_.drift_covariance.setZero();
  }
  body_.begin(identity_.T_world_obj.inverse() * camera.T_world_cam, life_.status);
}

}  // namespace kinetrace::pipeline

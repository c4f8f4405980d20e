// The part of ObjectState that locates and restarts its reconstruction.
#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "object_state.hpp"

namespace kinetrace::pipeline {
namespace {

constexpr double kPoseGate = 36.0;  // Chi-square with six degrees of freedom.

}  // namespace

bool ObjectState::locate(const FeatureFrame& frame, const CameraState& camera) {
  if (!is_rigid() || !body_.active()) {
    return false;
  }
  const std::optional<sfm::BodyReconstruction::Expectation> expected = expected_pose(camera);
  if (body_.locate(frame, life_.track.label(), expected ? &*expected : nullptr).status != BodyStatus::kTracked ||
      !camera.valid) {
    return false;
  }
  if (expected && !passes_innovation_gate(*expected)) {
    body_.refuse_pose();
    return false;
  }
  return true;
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

#include "kinetrace/hal/rig_calibration.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>

#include "util/messages.hpp"

namespace kinetrace::hal {
namespace {

constexpr int kMaxSide_px = 16384;
constexpr double kMaxBaseline_m = 10.0;
constexpr double kMinBaseline_m = 1e-3;       // Endoscopes have 4 mm.
constexpr double kRotationTolerance = 5e-3;   // Matrices written with three digits still pass.
constexpr double kMaxAxisTilt = 0.1;          // Tilt of the baseline against the rows of rectified images.
constexpr double kMinForwardAgreement = 0.7;  // Cosine between the views' viewing directions: 45 degrees.
constexpr double kIntrinsicsTolerance_px = 0.01;
// Relative to the longer side of the image: 0.25 for the widest fisheye lenses, 115 for a field of view of half a
// degree.
constexpr double kMinFocal = 0.02;
constexpr double kMaxFocal = 200.0;
// Ratio of distorted to undistorted distance from the optical axis. Halfway to the image border the widest lenses in
// use stay below 1.6.
constexpr double kMaxDistortion = 2.0;

using Projection = Eigen::Matrix<double, 3, 4>;

Unexpected<Error> bad(const std::string& source, const std::string& what) {
  return fail(ErrorCode::kBadCalibration, source + ": " + what);
}

Status check_focal(const std::string& source, std::string_view view, std::string_view key, double value, int size) {
  if (!std::isfinite(value) || value <= 0) {
    return bad(source, concat(view, " focal length ", key, " must be a positive number, got ", number(value),
                              "; calibrate again"));
  }
  if (value < kMinFocal * size || value > kMaxFocal * size) {
    return bad(source,
               concat(view, " focal length ", key, " = ", number(value), " px is that of no lens for images of ",
                      std::to_string(size), " px; give it in pixels, not in millimetres"));
  }
  return {};
}

Status check_principal(const std::string& source, std::string_view view, std::string_view key, double value, int size) {
  if (!std::isfinite(value) || value < -0.5 * size || value > 1.5 * size) {
    return bad(source, concat(view, " principal point ", key, " = ", number(value), " lies far outside the image of ",
                              std::to_string(size), " px; check the order of the intrinsics and the image size"));
  }
  return {};
}

Status check_pinhole(const std::string& source, std::string_view view, double fx, double fy, double cx, double cy,
                     int width, int height) {
  if (width <= 0 || height <= 0) {
    return bad(source, concat(view, " image size is missing; give width and height in pixels"));
  }
  if (width > kMaxSide_px || height > kMaxSide_px) {
    return bad(source, concat(view, " image size ", size_text(width, height), " is beyond ",
                              size_text(kMaxSide_px, kMaxSide_px), " pixels; correct the size"));
  }
  Status status = check_focal(source, view, "fx", fx, std::max(width, height));
  if (status) {
    status = check_focal(source, view, "fy", fy, std::max(width, height));
  }
  if (status) {
    status = check_principal(source, view, "cx", cx, width);
  }
  if (status) {
    status = check_principal(source, view, "cy", cy, height);
  }
  return status;
}

// Whether the distortion stretches or folds the image along a ray in this direction, halfway to its border:
// coefficients in another order or of another model do, those of a lens do not.
bool is_warped_along(const CameraModel& camera, const Eigen::Vector2d& direction) {
  constexpr int kSteps = 32;
  const double halfway_px = 0.25 * std::min(camera.width_px, camera.height_px);
  const double undistorted = halfway_px / std::hypot(camera.fx_px * direction.x(), camera.fy_px * direction.y());
  const Eigen::Vector2d centre_px(camera.cx_px, camera.cy_px);
  double reached_px = 0.0;
  double distance = 0.0;
  while (reached_px < halfway_px) {
    distance += undistorted / kSteps;
    const Eigen::Vector2d ray = distance * direction;
    const double next_px = (camera.project({ray.x(), ray.y(), 1.0}) - centre_px).norm();
    if (!(next_px > reached_px) || distance > kMaxDistortion * undistorted) {
      return true;
    }
    reached_px = next_px;
  }
  return distance < undistorted / kMaxDistortion;
}

Status check_distortion(const std::string& source, std::string_view view, const CameraModel& camera) {
  for (const double coefficient : camera.distortion) {
    if (!std::isfinite(coefficient)) {
      return bad(source, concat(view, " distortion holds a value that is no number; calibrate again"));
    }
  }
  constexpr int kDirections = 8;
  for (int i = 0; i < kDirections; ++i) {
    const double angle_rad = 2.0 * std::numbers::pi * i / kDirections;
    if (is_warped_along(camera, {std::cos(angle_rad), std::sin(angle_rad)})) {
      return bad(source, concat(view,
                                " distortion is that of no lens: it tears or folds the image halfway to its border; "
                                "check the order of the coefficients and the lens model"));
    }
  }
  return {};
}

Status check_camera(const std::string& source, std::string_view view, const CameraModel& camera) {
  const Status pinhole = check_pinhole(source, view, camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px,
                                       camera.width_px, camera.height_px);
  return pinhole ? check_distortion(source, view, camera) : pinhole;
}

// Corrects the rounding of matrices written with few digits; rejects matrices that are no rotation.
Status repair_rotation(const std::string& source, std::string_view name, Eigen::Matrix3d& rotation) {
  const double deviation = (rotation.transpose() * rotation - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!rotation.allFinite() || deviation > kRotationTolerance || rotation.determinant() <= 0) {
    return bad(source, concat(name, " is no rotation matrix (R^T R deviates from the identity by ", number(deviation),
                              "); check that it is complete and row-major"));
  }
  rotation = orthonormalised(rotation);
  return {};
}

// `offset`: centre of the right view in the frame of the left one.
Status check_baseline(const std::string& source, const Eigen::Vector3d& offset, double max_tilt) {
  const double length = offset.norm();
  if (!std::isfinite(length) || length < kMinBaseline_m) {
    return bad(source, concat("the baseline is ", number(length),
                              " m; the translation between the views is missing or zero, or not in metres"));
  }
  const double across = offset.tail<2>().norm();
  if (across > max_tilt * std::abs(offset.x())) {
    return bad(source, concat("the baseline is not horizontal (right view at x ", number(offset.x()), ", y ",
                              number(offset.y()), ", z ", number(offset.z()),
                              " m from the left one); this needs views side by side"));
  }
  if (offset.x() < 0) {
    return bad(source, concat("the baseline is negative (", number(offset.x()),
                              " m): left and right look swapped; exchange the two cameras"));
  }
  if (length > kMaxBaseline_m) {
    return bad(source, concat("the baseline is ", number(length),
                              " m; translations must be in metres, was this calibrated in millimetres?"));
  }
  return {};
}

Status check_geometry(const std::string& source, const StereoGeometry& geometry) {
  const Status pinhole = check_pinhole(source, "rectified", geometry.fx_px, geometry.fy_px, geometry.cx_px,
                                       geometry.cy_px, geometry.width_px, geometry.height_px);
  return pinhole ? check_baseline(source, {geometry.baseline_m, 0.0, 0.0}, 1.0) : pinhole;
}

Status validate_given(const std::string& source, RectifyingTransforms& given) {
  Status status = repair_rotation(source, "the left rectifying rotation", given.R_left);
  if (status) {
    status = repair_rotation(source, "the right rectifying rotation", given.R_right);
  }
  if (status) {
    const auto geometry =
        geometry_from_projections(given.P_left, given.P_right, given.width_px, given.height_px, source);
    status = geometry ? Status{} : Unexpected(geometry.error());
  }
  return status;
}

Status validate_transform(const std::string& source, Se3& T_right_left) {
  if (Status rotation = repair_rotation(source, "the rotation between the views", T_right_left.rotation); !rotation) {
    return rotation;
  }
  if (T_right_left.rotation(2, 2) < kMinForwardAgreement) {
    return bad(source,
               "the views look in different directions (more than 45 degrees apart); check the rotation between them");
  }
  return check_baseline(source, T_right_left.inverse().translation, 1.0);
}

// Centre of the camera P = K [I | t] in the common frame: -K^-1 P[:, 3].
Eigen::Vector3d centre(const Projection& P) {
  return -(P.leftCols<3>().inverse() * P.col(3));
}

}  // namespace

Status RigCalibration::validate() {
  if (rectified) {
    return check_geometry(source, *rectified);
  }
  Status status = check_camera(source, "left", left);
  if (status) {
    status = check_camera(source, "right", right);
  }
  if (status && (left.width_px != right.width_px || left.height_px != right.height_px)) {
    status = bad(source, concat("the views have different image sizes, left ", size_text(left.width_px, left.height_px),
                                ", right ", size_text(right.width_px, right.height_px), "; both must be the same"));
  }
  if (status) {
    status = given ? validate_given(source, *given) : validate_transform(source, T_right_left);
  }
  return status;
}

Result<RigCalibration> images_alone(int width_px, int height_px) {
  const CameraModel camera{.width_px = width_px,
                           .height_px = height_px,
                           .fx_px = static_cast<double>(std::max(width_px, height_px)),
                           .fy_px = static_cast<double>(std::max(width_px, height_px)),
                           .cx_px = (width_px - 1) / 2.0,
                           .cy_px = (height_px - 1) / 2.0};
  RigCalibration rig;
  rig.source = "images without calibration";
  rig.left = rig.right = camera;
  rig.T_right_left.translation.x() = -0.1;
  if (const Status valid = rig.validate(); !valid) {
    return Unexpected(valid.error());
  }
  return rig;
}

Result<StereoGeometry> geometry_from_projections(const Projection& P_left, const Projection& P_right, int width_px,
                                                 int height_px, const std::string& source) {
  if (!P_left.allFinite() || !P_right.allFinite()) {
    return bad(source, "a projection matrix holds a value that is no number; calibrate again");
  }
  StereoGeometry geometry{.fx_px = P_left(0, 0),
                          .fy_px = P_left(1, 1),
                          .cx_px = P_left(0, 2),
                          .cy_px = P_left(1, 2),
                          .width_px = width_px,
                          .height_px = height_px};
  if (const Status pinhole = check_pinhole(source, "rectified", geometry.fx_px, geometry.fy_px, geometry.cx_px,
                                           geometry.cy_px, width_px, height_px);
      !pinhole) {
    return Unexpected(pinhole.error());
  }
  const double difference = (P_left.leftCols<3>() - P_right.leftCols<3>()).cwiseAbs().maxCoeff();
  if (difference > kIntrinsicsTolerance_px) {
    return bad(source, concat("the projection matrices of left and right differ by ", number(difference),
                              " px in focal length or principal point; rectify with equal ones (zero disparity at "
                              "infinity)"));
  }
  const Eigen::Vector3d offset = centre(P_right) - centre(P_left);
  if (const Status baseline = check_baseline(source, offset, kMaxAxisTilt); !baseline) {
    return Unexpected(baseline.error());
  }
  geometry.baseline_m = offset.x();
  return geometry;
}

}  // namespace kinetrace::hal

#include "trajectory_rows.hpp"

#include <cmath>
#include <numbers>

#include "kinetrace/core/class_name.hpp"

namespace kinetrace::recording {
namespace {

constexpr int kMetreDecimals = 6;
constexpr int kUnitDecimals = 9;
constexpr int kSignificantDigits = 9;

std::string_view kitti_type(std::uint16_t class_id) noexcept {
  return class_id == kVehicleClass ? "Car" : class_id == kPedestrianClass ? "Pedestrian" : "Misc";
}

/// Score of a label for ranking, by the support of its pose.
double kitti_score(BodyStatus status) noexcept {
  return status == BodyStatus::kTracked ? 1.0 : status == BodyStatus::kStereoOnly ? 0.5 : 0.25;
}

void write_position(const Eigen::Vector3d& v, std::string_view separator, BufferedWriter& out) noexcept {
  for (int i = 0; i < 3; ++i) {
    out.text(separator).fixed(v[i], kMetreDecimals);
  }
}

void write_quaternion(const std::array<double, 4>& q_xyzw, std::string_view separator, BufferedWriter& out) noexcept {
  for (const double q : q_xyzw) {
    out.text(separator).fixed(q, kUnitDecimals);
  }
}

}  // namespace

KittiPlacement kitti_placement(const Box3& box, const Se3& T_world_cam) {
  const Se3 T_cam_world = T_world_cam.inverse();
  const Eigen::Matrix3d R_world_box = box.rotation();
  KittiPlacement placement;
  placement.location_m = T_cam_world * (box.center_m + 0.5 * box.size_m.y() * R_world_box.col(1));
  const Eigen::Vector3d along_cam = T_cam_world.rotation * R_world_box.col(0);
  placement.rotation_y_rad = std::atan2(-along_cam.z(), along_cam.x());
  const double ray = std::atan2(placement.location_m.x(), placement.location_m.z());
  placement.alpha_rad = std::remainder(placement.rotation_y_rad - ray, 2.0 * std::numbers::pi);
  return placement;
}

void write_tum_row(std::int64_t timestamp_ns, const StoredPose& pose, BufferedWriter& out) noexcept {
  constexpr std::int64_t kNsPerS = 1'000'000'000;
  // Whole and fractional seconds separately: a double would lose nanoseconds of today's clocks.
  const auto magnitude = timestamp_ns < 0 ? std::uint64_t{0} - static_cast<std::uint64_t>(timestamp_ns)
                                          : static_cast<std::uint64_t>(timestamp_ns);
  std::array<char, 10> fraction{'.', '0', '0', '0', '0', '0', '0', '0', '0', '0'};
  std::uint64_t rest = magnitude % kNsPerS;
  for (std::size_t digit = fraction.size() - 1; digit > 0; --digit, rest /= 10) {
    fraction[digit] = static_cast<char>('0' + rest % 10);
  }
  out.text(timestamp_ns < 0 ? "-" : "").integer(magnitude / kNsPerS);
  out.text(std::string_view(fraction.data(), fraction.size()));
  write_position(Eigen::Vector3d(pose.translation_m.data()), " ", out);
  write_quaternion(pose.quaternion_xyzw, " ", out);
  out.text("\n");
}

void write_frame_row(const FrameEstimate& frame, BufferedWriter& out) noexcept {
  out.integer(frame.frame_index).text(",").integer(frame.timestamp_ns).text("\n");
}

void write_kitti_row(const Se3& T_world_cam, BufferedWriter& out) noexcept {
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      out.text(row + column == 0 ? "" : " ").general(T_world_cam.rotation(row, column), kSignificantDigits);
    }
    out.text(" ").general(T_world_cam.translation[row], kSignificantDigits);
  }
  out.text("\n");
}

void write_object_row(const FrameEstimate& frame, const ObjectResult& object, BufferedWriter& out) noexcept {
  const StoredPose pose = StoredPose::from(object.T_world_obj);
  out.integer(frame.frame_index).text(",").integer(frame.timestamp_ns).text(",").integer(object.track_id).text(",");
  out.text(ClassName(object.class_id).view());
  out.text(",").text(to_string(object.status));
  write_position(object.T_world_obj.translation, ",", out);
  write_quaternion(pose.quaternion_xyzw, ",", out);
  write_position(object.velocity_mps, ",", out);
  out.text(object.moving ? ",1," : ",0,").fixed(object.heading_rad, kMetreDecimals);
  write_position(object.box.center_m, ",", out);
  write_position(object.box.size_m, ",", out);
  out.text(",").fixed(object.box.yaw_rad, kMetreDecimals);
  for (int i = 0; i < 6; ++i) {
    out.text(",").general(object.covariance(i, i), kSignificantDigits);
  }
  const PixelBox& mask = object.box_px;
  const int pixel_height = mask.empty() ? 0 : mask.height();
  for (const int value : {object.point_count, object.inliers, pixel_height, mask.x0, mask.y0, mask.x1, mask.y1}) {
    out.text(",").integer(value);
  }
  write_position(object.box.down, ",", out);
  write_position(object.box_sigma.center_m, ",", out);
  write_position(object.box_sigma.size_m, ",", out);
  out.text(",").fixed(object.box_sigma.yaw_rad, kMetreDecimals);
  out.text(object.box_sigma.heading_known ? ",1\n" : ",0\n");
}

bool write_label_row(const FrameEstimate& frame, const ObjectResult& object, BufferedWriter& out) noexcept {
  if (object.status == BodyStatus::kLost || object.box_px.empty()) {
    return false;
  }
  const KittiPlacement placement = kitti_placement(object.box, frame.camera.T_world_cam);
  out.integer(frame.frame_index).text(" ").integer(object.track_id).text(" ").text(kitti_type(object.class_id));
  out.text(" -1 -1 ").fixed(placement.alpha_rad, kMetreDecimals);  // Truncation and occlusion are not estimated.
  // KITTI's boxes include their last row and column.
  const PixelBox& mask = object.box_px;
  for (const int edge : {mask.x0, mask.y0, mask.x1 - 1, mask.y1 - 1}) {
    out.text(" ").integer(edge);
  }
  const Eigen::Vector3d& length_height_width = object.box.size_m;
  write_position({length_height_width.y(), length_height_width.z(), length_height_width.x()}, " ", out);
  write_position(placement.location_m, " ", out);
  out.text(" ").fixed(placement.rotation_y_rad, kMetreDecimals);
  out.text(" ").general(kitti_score(object.status), kSignificantDigits).text("\n");
  return true;
}

}  // namespace kinetrace::recording

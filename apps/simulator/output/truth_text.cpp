#include "output/truth_text.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <iomanip>
#include <sstream>
#include <string_view>

#include "kinetrace/core/class_name.hpp"

namespace kinetrace::simulator {
namespace {

std::string_view kitti_type(std::uint16_t class_id) {
  return class_id == kVehicleClass ? "Car" : class_id == kPedestrianClass ? "Pedestrian" : "Misc";
}

template <typename Values>
void write_entry(std::ostream& out, const std::string& key, const Values& values) {
  out << key << ':';
  for (const double value : values) {
    out << ' ' << value;
  }
  out << '\n';
}

template <typename Matrix>
std::vector<double> row_major(const Matrix& matrix) {
  std::vector<double> values;
  for (int row = 0; row < matrix.rows(); ++row) {
    for (int column = 0; column < matrix.cols(); ++column) {
      values.push_back(matrix(row, column));
    }
  }
  return values;
}

// KITTI's levels: 0 complete, 1 partly, 2 largely missing.
int level(double part, double partly, double largely) {
  return part < partly ? 0 : part < largely ? 1 : 2;
}

}  // namespace

const char* const kRightCameraHeader =
    "frame,turn_x_rad,turn_y_rad,turn_z_rad,baseline_y_rad,baseline_z_rad,shift_x,shift_y\n";

void write_right_camera_row(const SimulatedFrame& frame, std::ostream& out) {
  const RigErrors::RightCamera& right = frame.right_camera;
  out << frame.index;
  for (const double value : {right.turn_rad.x(), right.turn_rad.y(), right.turn_rad.z(), right.baseline_rad.x(),
                             right.baseline_rad.y(), right.principal_shift.x(), right.principal_shift.y()}) {
    out << ',' << value;
  }
  out << '\n';
}

const char* const kObjectsHeader =
    "frame,timestamp_ns,object_id,class,moving,rigid,tx,ty,tz,qx,qy,qz,qw,vx,vy,vz,length,height,width,visible_px,"
    "height_px,occlusion,truncation\n";

std::string calibration_text(const CameraRig& rig) {
  std::ostringstream out;
  out << std::scientific << std::setprecision(12);
  out << "calib_time: 01-Jan-2026 00:00:00\n";
  const StereoGeometry& g = rig.rectified;
  const Eigen::Vector3d right_centre(g.baseline_m, 0.0, 0.0);
  for (std::size_t side = 0; side < 2; ++side) {
    const RawCamera& camera = rig.raw[side];
    const std::string id = side == 0 ? "_00" : "_01";
    // Pose of the raw camera against raw camera 00: p_side = R p_00 + T.
    const Eigen::Matrix3d R = camera.R_rect.transpose() * rig.raw[0].R_rect;
    const Eigen::Vector3d T =
        side == 0 ? Eigen::Vector3d::Zero() : Eigen::Vector3d(-camera.R_rect.transpose() * right_centre);
    Eigen::Matrix<double, 3, 4> P = Eigen::Matrix<double, 3, 4>::Zero();
    P(0, 0) = g.fx_px;
    P(1, 1) = g.fy_px;
    P(0, 2) = g.cx_px;
    P(1, 2) = g.cy_px;
    P(2, 2) = 1.0;
    P(0, 3) = side == 0 ? 0.0 : -g.fx_px * g.baseline_m;
    write_entry(out, "S" + id, std::array<double, 2>{double(camera.width_px), double(camera.height_px)});
    write_entry(out, "K" + id, row_major(camera.K));
    write_entry(out, "D" + id, camera.distortion);
    write_entry(out, "R" + id, row_major(R));
    write_entry(out, "T" + id, row_major(T));
    write_entry(out, "S_rect" + id, std::array<double, 2>{double(g.width_px), double(g.height_px)});
    write_entry(out, "R_rect" + id, row_major(camera.R_rect));
    write_entry(out, "P_rect" + id, row_major(P));
  }
  return out.str();
}

std::string timestamp_text(std::int64_t timestamp_ns) {
  constexpr std::int64_t kSecond_ns = 1'000'000'000;
  const auto seconds = static_cast<std::time_t>(timestamp_ns / kSecond_ns);
  std::tm parts{};
  gmtime_r(&seconds, &parts);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%d %H:%M:%S", &parts);
  std::ostringstream out;
  out << text.data() << '.' << std::setw(9) << std::setfill('0') << timestamp_ns % kSecond_ns;
  return out.str();
}

void write_pose(const Se3& pose, std::ostream& out) {
  Eigen::Matrix<double, 3, 4> matrix;
  matrix << pose.rotation, pose.translation;
  const std::vector<double> values = row_major(matrix);
  for (std::size_t i = 0; i < values.size(); ++i) {
    out << (i == 0 ? "" : " ") << values[i];
  }
  out << '\n';
}

void write_object_row(const SimulatedFrame& frame, const ObjectTruth& object, std::ostream& out) {
  const Eigen::Quaterniond q = object.T_world_obj.quaternion();
  const Eigen::Vector3d& t = object.T_world_obj.translation;
  const Eigen::Vector3d& v = object.velocity_mps;
  const Eigen::Vector3d& s = object.size_lhw_m;
  out << frame.index << ',' << frame.timestamp_ns << ',' << object.id << ',' << ClassName(object.class_id).view() << ','
      << object.moving << ',' << object.rigid;
  for (const double value :
       {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w(), v.x(), v.y(), v.z(), s.x(), s.y(), s.z()}) {
    out << ',' << value;
  }
  out << ',' << object.visible_px << ',' << object.box_px.height() << ',' << object.occlusion << ','
      << object.truncation << '\n';
}

void write_label(const SimulatedFrame& frame, const ObjectTruth& object, std::ostream& out) {
  if (object.visible_px == 0) {
    return;
  }
  const Se3 T_cam_obj = frame.T_world_cam.inverse() * object.T_world_obj;
  const Eigen::Vector3d& t = T_cam_obj.translation;
  const Eigen::Vector3d forward = T_cam_obj.rotation.col(0);
  const double rotation_y = std::atan2(-forward.z(), forward.x());
  const double alpha = std::remainder(rotation_y - std::atan2(t.x(), t.z()), 6.283185307179586);
  const Eigen::Vector3d& s = object.size_lhw_m;
  out << frame.index << ' ' << object.id << ' ' << kitti_type(object.class_id) << ' '
      << level(object.truncation, 0.02, 0.5) << ' ' << level(object.occlusion, 0.1, 0.5) << ' ' << alpha;
  for (const double edge : object.projected_px) {
    out << ' ' << edge;
  }
  for (const double value : {s.y(), s.z(), s.x(), t.x(), t.y(), t.z(), rotation_y}) {
    out << ' ' << value;
  }
  out << '\n';
}

}  // namespace kinetrace::simulator

#include "object_gaps.hpp"

#include <algorithm>

namespace kinetrace::batch {
namespace {

// What brakes and engines usually do; positions at both ends are known to some decimetres.
constexpr double kAcceleration_mps2 = 3.0;
constexpr double kPosition_m = 0.3;
constexpr double kLongest_s = 5.0;

/// Cubic of positions from one end of a gap to the other, with the velocities there (Hermite).
struct GapPath {
  Eigen::Vector3d from_m, to_m, from_mps, to_mps;
  double time_s = 0.0;

  [[nodiscard]] Eigen::Vector3d position_m(double s) const {
    const double s2 = s * s;
    const double s3 = s2 * s;
    return (2.0 * s3 - 3.0 * s2 + 1.0) * from_m + (s3 - 2.0 * s2 + s) * time_s * from_mps +
           (3.0 * s2 - 2.0 * s3) * to_m + (s3 - s2) * time_s * to_mps;
  }
  [[nodiscard]] Eigen::Vector3d velocity_mps(double s) const {
    return 6.0 * (s * s - s) / time_s * (from_m - to_m) + (3.0 * s * s - 4.0 * s + 1.0) * from_mps +
           (3.0 * s * s - 2.0 * s) * to_mps;
  }
  /// The largest on the way, which is at one of the ends: acceleration is linear in between.
  [[nodiscard]] double acceleration_mps2() const {
    const Eigen::Vector3d way = 6.0 / (time_s * time_s) * (to_m - from_m);
    const Eigen::Vector3d at_start = way - (4.0 * from_mps + 2.0 * to_mps) / time_s;
    const Eigen::Vector3d at_end = (2.0 * from_mps + 4.0 * to_mps) / time_s - way;
    return std::max(at_start.norm(), at_end.norm());
  }
  [[nodiscard]] bool is_possible() const {
    return time_s <= kLongest_s && acceleration_mps2() <= kAcceleration_mps2 + 6.0 * kPosition_m / (time_s * time_s);
  }
};

GapPath path_between(const recording::ObjectRow& from, const recording::ObjectRow& to) {
  return {from.box.center_m, to.box.center_m, from.velocity_mps, to.velocity_mps,
          1e-9 * static_cast<double>(to.timestamp_ns - from.timestamp_ns)};
}

}  // namespace

void fill_gaps(const recording::Run& run, std::span<const Se3> T_world_cam, RefinedObject& object) {
  const std::map<std::size_t, RefinedObjectFrame> frames = object.frames;
  auto before = frames.end();
  for (auto frame = frames.begin(); frame != frames.end(); ++frame) {
    if (frame->second.row.status == BodyStatus::kLost) {
      continue;
    }
    const recording::ObjectRow& to = frame->second.row;
    const std::size_t rows = before == frames.end() ? 1 : frame->first - before->first;
    const GapPath path = rows > 1 ? path_between(before->second.row, to) : GapPath{};
    for (std::size_t k = 1; rows > 1 && path.is_possible() && k < rows; ++k) {
      const recording::ObjectRow& from = before->second.row;
      const std::size_t at = before->first + k;
      const recording::CameraRow& camera = run.camera[at];
      const double s = 1e-9 * static_cast<double>(camera.timestamp_ns - from.timestamp_ns) / path.time_s;
      RefinedObjectFrame& filled = object.frames[at];
      const int pixel_height = filled.row.pixel_height;
      const PixelBox mask_px = filled.row.mask_px;
      filled.row = s < 0.5 ? from : to;
      filled.row.frame = camera.frame;
      filled.row.timestamp_ns = camera.timestamp_ns;
      filled.row.status = BodyStatus::kPropagated;
      filled.row.pixel_height = pixel_height;
      filled.row.mask_px = mask_px;
      filled.row.inliers = 0;
      const Eigen::Vector3d moved_m = path.position_m(s) - filled.row.box.center_m;
      filled.row.box.center_m += moved_m;
      filled.row.T_world_obj.translation += moved_m;
      filled.row.velocity_mps = path.velocity_mps(s);
      filled.T_obj_cam = filled.row.T_world_obj.inverse() * T_world_cam[at];
    }
    before = frame;
  }
}

}  // namespace kinetrace::batch

#include "keyframes.hpp"

#include <cmath>
#include <unordered_map>

#include "../run_observations.hpp"
#include "kinetrace/core/quantiles.hpp"
#include "pose_information.hpp"

namespace kinetrace::batch {
namespace {

constexpr double kMinDisparity_px = 0.25;
constexpr std::size_t kMaxPoints = 500;
constexpr std::size_t kMinPoints = 8;
constexpr double kKeyframeDistance_depths = 0.05;
constexpr double kKeyframeTurn_rad = 0.0873;
// In frames with very few points, a step is the run's, with this uncertainty.
constexpr double kStepRotation_rad = 0.02;
constexpr double kStepPosition_m = 0.3;

class PathObserver {
 public:
  PathObserver(const recording::Run& run, std::span<const Se3> T_world_cam, double sigma_px)
      : geometry_(run.rectified), T_world_cam_(T_world_cam), sigma_px_(sigma_px) {
    Vector6d floor;
    floor << Eigen::Vector3d::Constant(1.0 / (kStepRotation_rad * kStepRotation_rad)),
        Eigen::Vector3d::Constant(1.0 / (kStepPosition_m * kStepPosition_m));
    path_.step_information.assign(T_world_cam.size(), floor.asDiagonal());
    for (std::size_t row = 1; row < T_world_cam.size(); ++row) {
      travelled_m_.push_back(travelled_m_.back() +
                             (T_world_cam[row].translation - T_world_cam[row - 1].translation).norm());
    }
  }

  void observe(std::size_t row, std::span<const recording::Observation> seen) {
    std::vector<SeenPoint> points;
    for (const recording::Observation& each : seen) {
      if (each.track_id == 0 && each.u_left_px - each.u_right_px > kMinDisparity_px) {
        points.push_back({0, each.point_id, {each.u_left_px, each.v_px, each.u_right_px}});
      }
    }
    add_step(row, points);
    add_keyframe(row, points);
    before_ = std::move(points);
    row_before_ = row;
  }

  ObservedPath take() { return std::move(path_); }

 private:
  [[nodiscard]] Eigen::Vector3d position_m(const SeenPoint& point) const {
    const Eigen::Vector3d px = point.px.cast<double>();
    return geometry_.triangulate(px.x(), px.y(), px.x() - px.z());
  }

  void add_step(std::size_t row, const std::vector<SeenPoint>& points) {
    if (row == 0 || row_before_ + 1 != row) {
      return;
    }
    std::unordered_map<std::uint32_t, const SeenPoint*> now;
    for (const SeenPoint& point : points) {
      now.emplace(point.point_id, &point);
    }
    std::vector<Eigen::Vector3d> shared_m;
    for (const SeenPoint& point : before_) {
      if (now.contains(point.point_id)) {
        shared_m.push_back(position_m(point));
      }
    }
    path_.step_information[row] += pose_information(geometry_, shared_m, sigma_px_);
  }

  /// Sum of the steps' variances up to this row; rows come in ascending order.
  double variance_m2(std::size_t row) {
    for (; rows_summed_ <= row; ++rows_summed_) {
      variance_m2_ += path_.step_information[rows_summed_].inverse().diagonal().tail<3>().sum();
    }
    return variance_m2_;
  }

  void add_keyframe(std::size_t row, const std::vector<SeenPoint>& points) {
    if (points.size() < kMinPoints || (!path_.keyframes.empty() && !shows_other_things(row))) {
      return;
    }
    std::vector<double> depths_m;
    depths_m.reserve(points.size());
    for (const SeenPoint& point : points) {
      depths_m.push_back(position_m(point).z());
    }
    Keyframe keyframe{row, median(depths_m), travelled_m_[row], variance_m2(row), {}};
    const std::size_t step = (points.size() + kMaxPoints - 1) / kMaxPoints;
    for (std::size_t i = 0; i < points.size(); i += step) {
      keyframe.points.push_back(points[i]);
    }
    path_.keyframes.push_back(std::move(keyframe));
  }

  [[nodiscard]] bool shows_other_things(std::size_t row) const {
    const Keyframe& last = path_.keyframes.back();
    const Se3 T_last_now = T_world_cam_[last.row].inverse() * T_world_cam_[row];
    return T_last_now.translation.norm() > kKeyframeDistance_depths * last.depth_m ||
           so3_log(T_last_now.rotation).norm() > kKeyframeTurn_rad;
  }

  const StereoGeometry& geometry_;
  std::span<const Se3> T_world_cam_;
  double sigma_px_;
  std::vector<double> travelled_m_{0.0};
  std::vector<SeenPoint> before_;
  std::size_t row_before_ = 0;
  std::size_t rows_summed_ = 1;
  double variance_m2_ = 0.0;
  ObservedPath path_;
};

}  // namespace

Result<ObservedPath> observe_path(const recording::Run& run, const MeasuredBackground& measured,
                                  std::span<const Se3> T_world_cam, double sigma_px) {
  Result<RunObservations> reader = RunObservations::open(run, measured);
  if (!reader) {
    return Unexpected(reader.error());
  }
  std::unordered_map<std::int64_t, std::size_t> rows;
  for (std::size_t row = 0; row < run.camera.size(); ++row) {
    rows.emplace(run.camera[row].frame, row);
  }
  PathObserver observer(run, T_world_cam, sigma_px);
  while (true) {
    const Result<std::span<const recording::Observation>> seen = reader->next_frame();
    if (!seen) {
      return Unexpected(seen.error());
    }
    if (seen->empty()) {
      return observer.take();
    }
    if (const auto row = rows.find(seen->front().frame); row != rows.end()) {
      observer.observe(row->second, *seen);
    }
  }
}

}  // namespace kinetrace::batch

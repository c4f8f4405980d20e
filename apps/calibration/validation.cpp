#include "validation.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "kinetrace/core/quantiles.hpp"
#include "lens.hpp"

namespace kinetrace::calibration {
namespace {

// Rotation from the left camera's frame into that of parallel views: x along the baseline (Fusiello, Trucco and Verri,
// "A compact algorithm for rectification of stereo pairs", 2000).
Eigen::Matrix3d rectifying_rotation(const Se3& T_right_left) {
  const Eigen::Vector3d x = T_right_left.inverse().translation.normalized();
  const Eigen::Vector3d y = Eigen::Vector3d::UnitZ().cross(x).normalized();
  Eigen::Matrix3d R;
  R << x.transpose(), y.transpose(), x.cross(y).transpose();
  return R;
}

// A corner visible in both images, in the frame of the rectified left view.
struct Pair {
  int id = 0;
  double rows_px = 0.0;
  Eigen::Vector3d p_m;
};

class Triangulation {
 public:
  explicit Triangulation(const hal::RigCalibration& rig)
      : rig_(rig),
        R_left_(rectifying_rotation(rig.T_right_left)),
        R_right_(R_left_ * rig.T_right_left.rotation.transpose()),
        baseline_m_(rig.T_right_left.translation.norm()),
        focal_px_((rig.left.fy_px + rig.right.fy_px) / 2) {}

  [[nodiscard]] std::optional<Pair> pair(const Corner& left, const Corner& right) const {
    const auto in_left = direction(rig_.left, R_left_, left.px);
    const auto in_right = direction(rig_.right, R_right_, right.px);
    if (!in_left || !in_right || in_left->x() - in_right->x() <= 0.0) {
      return std::nullopt;
    }
    const double depth_m = baseline_m_ / (in_left->x() - in_right->x());
    const double y = (in_left->y() + in_right->y()) / 2;
    return Pair{left.id, focal_px_ * (in_right->y() - in_left->y()), depth_m * Eigen::Vector3d(in_left->x(), y, 1.0)};
  }

 private:
  static std::optional<Eigen::Vector2d> direction(const hal::CameraModel& camera, const Eigen::Matrix3d& R,
                                                  const Eigen::Vector2d& px) {
    const auto ray = normalised_ray(camera, px);
    if (!ray) {
      return std::nullopt;
    }
    const Eigen::Vector3d turned = R * ray->homogeneous();
    return turned.z() > 0.0 ? std::optional<Eigen::Vector2d>(turned.hnormalized()) : std::nullopt;
  }

  const hal::RigCalibration& rig_;
  Eigen::Matrix3d R_left_;
  Eigen::Matrix3d R_right_;
  double baseline_m_;
  double focal_px_;
};

std::vector<Pair> pairs_of(const Triangulation& triangulation, const BoardView& view) {
  std::vector<Pair> pairs;
  for (const Corner& left : view.left) {
    const auto right = std::find_if(view.right.begin(), view.right.end(),
                                    [&left](const Corner& corner) { return corner.id == left.id; });
    if (right == view.right.end()) {
      continue;
    }
    if (const auto pair = triangulation.pair(left, *right)) {
      pairs.push_back(*pair);
    }
  }
  return pairs;
}

// By rows: corners with many times the usual difference were not measured well.
std::size_t reject_outliers(std::vector<std::vector<Pair>>& views) {
  std::vector<double> rows;
  for (const auto& view : views) {
    for (const Pair& pair : view) {
      rows.push_back(std::abs(pair.rows_px));
    }
  }
  if (rows.empty()) {
    return 0;
  }
  constexpr double kMinLimit_px = 0.2;
  const double limit_px = std::max(kMinLimit_px, 8.0 * median(rows));
  std::size_t rejected = 0;
  for (auto& view : views) {
    rejected += std::erase_if(view, [limit_px](const Pair& pair) { return std::abs(pair.rows_px) > limit_px; });
  }
  return rejected;
}

}  // namespace

Validation validate(const hal::RigCalibration& rig, const Target& target, std::span<const BoardView> views) {
  const Triangulation triangulation(rig);
  Validation found;
  double rows = 0.0;
  double sum = 0.0;
  double squares = 0.0;
  double lengths = 0.0;
  std::vector<std::vector<Pair>> all;
  for (const BoardView& view : views) {
    all.push_back(pairs_of(triangulation, view));
  }
  found.rejected_corners = reject_outliers(all);
  for (const std::vector<Pair>& pairs : all) {
    found.views += pairs.empty() ? 0U : 1U;
    found.corners += pairs.size();
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      rows += pairs[i].rows_px * pairs[i].rows_px;
      found.epipolar_max_px = std::max(found.epipolar_max_px, std::abs(pairs[i].rows_px));
      // To a corner half a target away.
      const Pair& other = pairs[(i + pairs.size() / 2) % pairs.size()];
      const double true_m =
          (target.points_m[static_cast<std::size_t>(pairs[i].id)] - target.points_m[static_cast<std::size_t>(other.id)])
              .norm();
      if (true_m > 0.0) {
        const double error = (pairs[i].p_m - other.p_m).norm() / true_m - 1.0;
        sum += error;
        squares += error * error;
        lengths += 1.0;
      }
    }
  }
  found.epipolar_rms_px = std::sqrt(rows / std::max<double>(static_cast<double>(found.corners), 1.0));
  found.length_error = sum / std::max(lengths, 1.0);
  found.length_rms = std::sqrt(squares / std::max(lengths, 1.0));
  return found;
}

}  // namespace kinetrace::calibration

#include "kinetrace/evaluation/camera_metrics.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "rotation_angle.hpp"

namespace kinetrace::evaluation {
namespace {

constexpr std::array<double, 8> kKittiLengths_m{100, 200, 300, 400, 500, 600, 700, 800};
constexpr std::array<double, 5> kShortLengths_m{5, 10, 20, 50, 100};
constexpr double kMinSpread_m =
    0.1;  // The scale of a stationary camera is undetermined: noise would be fitted to noise.
constexpr double kLongPath_m = 200.0;  // At least two of KITTI's lengths.

/// Error of the estimated motion from `a` to `b`.
Se3 relative_error(const PosePair& a, const PosePair& b) {
  const Se3 true_motion = a.T_world_cam_true.inverse() * b.T_world_cam_true;
  const Se3 motion = a.T_world_cam.inverse() * b.T_world_cam;
  return true_motion.inverse() * motion;
}

ErrorStatistics distances(const Eigen::Matrix3Xd& a, const Eigen::Matrix3Xd& b) {
  ErrorStatistics errors;
  for (Eigen::Index i = 0; i < a.cols(); ++i) {
    errors.add((a.col(i) - b.col(i)).norm());
  }
  return errors;
}

/// Root mean square distance of the points from their middle.
double spread_m(const Eigen::Matrix3Xd& points) {
  const Eigen::Vector3d middle = points.rowwise().mean();
  return std::sqrt((points.colwise() - middle).squaredNorm() / static_cast<double>(points.cols()));
}

AbsoluteErrors absolute_errors(std::span<const PosePair> pairs) {
  AbsoluteErrors errors;
  if (pairs.empty()) {
    return errors;
  }
  const Se3 T_true_world = pairs.front().T_world_cam_true * pairs.front().T_world_cam.inverse();
  const auto count = static_cast<Eigen::Index>(pairs.size());
  Eigen::Matrix3Xd truth(3, count);
  Eigen::Matrix3Xd estimate(3, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const PosePair& pair = pairs[static_cast<std::size_t>(i)];
    truth.col(i) = pair.T_world_cam_true.translation;
    estimate.col(i) = T_true_world * pair.T_world_cam.translation;
  }
  errors.first = distances(estimate, truth);
  if (count < 3) {
    return errors;
  }
  const auto aligned = [&](bool with_scale) {
    const Eigen::Matrix4d alignment = Eigen::umeyama(estimate, truth, with_scale);
    if (with_scale) {
      errors.scale = std::cbrt(alignment.topLeftCorner<3, 3>().determinant());
    }
    return distances((alignment.topLeftCorner<3, 3>() * estimate).colwise() + alignment.topRightCorner<3, 1>(), truth);
  };
  errors.se3 = aligned(false);
  if (spread_m(truth) > kMinSpread_m && spread_m(estimate) > 0.0) {
    errors.sim3 = aligned(true);
  }
  return errors;
}

std::vector<double> distances_along(std::span<const PosePair> pairs) {
  std::vector<double> along(pairs.size(), 0.0);
  for (std::size_t i = 1; i < pairs.size(); ++i) {
    along[i] =
        along[i - 1] + (pairs[i].T_world_cam_true.translation - pairs[i - 1].T_world_cam_true.translation).norm();
  }
  return along;
}

void add_consecutive_errors(std::span<const PosePair> pairs, CameraMetrics& metrics) {
  for (std::size_t i = 1; i < pairs.size(); ++i) {
    if (pairs[i].frame != pairs[i - 1].frame + 1) {
      continue;
    }
    const Se3 error = relative_error(pairs[i - 1], pairs[i]);
    metrics.rpe_translation_m.add(error.translation.norm());
    metrics.rpe_rotation_deg.add(rotation_angle_deg(error.rotation));
  }
}

void add_segments(std::span<const PosePair> pairs, std::span<const double> along, double length_m,
                  ErrorStatistics& all_t, ErrorStatistics& all_r, CameraMetrics& metrics) {
  ErrorStatistics t_rel;
  ErrorStatistics r_rel;
  for (std::size_t first = 0; first < pairs.size(); ++first) {
    const auto last = std::lower_bound(along.begin(), along.end(), along[first] + length_m);
    if (last == along.end()) {
      break;
    }
    const Se3 error = relative_error(pairs[first], pairs[static_cast<std::size_t>(last - along.begin())]);
    const double distance_m = *last - along[first];
    t_rel.add(100.0 * error.translation.norm() / distance_m);
    r_rel.add(rotation_angle_deg(error.rotation) / distance_m);
  }
  if (t_rel.count() > 0) {
    metrics.segments.push_back({length_m, t_rel.count(), *t_rel.mean(), *r_rel.mean()});
    all_t.add(t_rel);
    all_r.add(r_rel);
  }
}

}  // namespace

CameraMetrics evaluate_camera(std::span<const PosePair> pairs) {
  CameraMetrics metrics;
  metrics.frames = pairs.size();
  metrics.ate_m = absolute_errors(pairs);
  add_consecutive_errors(pairs, metrics);

  const std::vector<double> along = distances_along(pairs);
  metrics.path_m = along.empty() ? 0.0 : along.back();
  const std::span<const double> lengths_m =
      metrics.path_m >= kLongPath_m ? std::span<const double>(kKittiLengths_m) : kShortLengths_m;
  ErrorStatistics t_rel;
  ErrorStatistics r_rel;
  for (const double length_m : lengths_m) {
    add_segments(pairs, along, length_m, t_rel, r_rel, metrics);
  }
  metrics.t_rel_percent = t_rel.mean();
  metrics.r_rel_deg_per_m = r_rel.mean();
  return metrics;
}

}  // namespace kinetrace::evaluation

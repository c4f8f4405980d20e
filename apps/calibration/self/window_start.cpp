#include "window_start.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <opencv2/calib3d.hpp>

namespace kinetrace::self_calibration {
namespace {

constexpr double kMinInverseDepth = 1e-4;
constexpr std::size_t kMinFrames = 3;

Se3 to_se3(const PoseBlock& pose) {
  return {so3_exp({pose[0], pose[1], pose[2]}), {pose[3], pose[4], pose[5]}};
}

class Chain {
 public:
  Chain(const RigModel& rig, const TrackWindow& tracks) : rig_(rig), tracks_(tracks) {
    window_.poses.resize(tracks.places.size());
    window_.points.resize(tracks.tracks.size());
    by_frame_.resize(tracks.places.size());
    for (std::size_t i = 0; i < tracks.tracks.size(); ++i) {
      window_.points[i].observations = tracks.tracks[i].observations;
      for (const Observation& seen : tracks.tracks[i].observations) {
        if (seen.view == 0) {
          by_frame_[seen.frame].push_back({i, seen.raw_px});
        }
      }
    }
  }

  std::optional<BundleWindow> run() {
    host_new_points(0);
    for (std::size_t frame = 1; frame < window_.poses.size(); ++frame) {
      if (!locate(frame)) {
        cut_off(frame);
        break;
      }
      host_new_points(frame);
    }
    if (window_.poses.size() < kMinFrames) {
      return std::nullopt;
    }
    for (BundlePoint& point : window_.points) {
      point.used = point.used && point.ray_and_inverse_depth[2] > 0.0;
    }
    return std::move(window_);
  }

 private:
  struct Seen {
    std::size_t point;
    Eigen::Vector2d raw_px;
  };

  void host_new_points(std::size_t frame) {
    for (const Seen& seen : by_frame_[frame]) {
      const Track& track = tracks_.tracks[seen.point];
      if (track.observations.front().frame != frame) {
        continue;
      }
      const Eigen::Vector2d ray = unproject(rig_.lens[0], rig_.size, seen.raw_px);
      const double w = inverse_depth(rig_, track.observations[0].raw_px, track.observations[1].raw_px);
      BundlePoint& point = window_.points[seen.point];
      point.T_host_world = to_se3(window_.poses[frame]);
      // Slightly behind infinity is noise, far behind it a wrong match.
      point.used = w > -3.0 / (rig_.focal_px(0) * rig_.baseline_m);
      point.ray_and_inverse_depth = {ray.x(), ray.y(), std::max(w, kMinInverseDepth)};
    }
  }

  /// Frames from here on are left out.
  void cut_off(std::size_t frame) {
    window_.poses.resize(frame);
    for (BundlePoint& point : window_.points) {
      std::erase_if(point.observations, [frame](const Observation& seen) { return seen.frame >= frame; });
    }
    std::erase_if(window_.points, [](const BundlePoint& point) {
      return point.observations.empty() || point.observations.front().frame == point.observations.back().frame;
    });
  }

  [[nodiscard]] bool locate(std::size_t frame) {
    constexpr std::size_t kMinPoints = 15;
    constexpr double kInlier_px = 4.0;
    constexpr int kSamples = 300;
    std::vector<cv::Point3d> points;
    std::vector<cv::Point2d> rays;
    std::vector<std::size_t> names;
    for (const Seen& seen : by_frame_[frame]) {
      const BundlePoint& point = window_.points[seen.point];
      if (point.observations.front().frame < frame && point.used) {
        const auto& [x, y, w] = point.ray_and_inverse_depth;
        const Eigen::Vector3d p_world = point.T_host_world.inverse() * Eigen::Vector3d(x / w, y / w, 1.0 / w);
        const Eigen::Vector2d ray = unproject(rig_.lens[0], rig_.size, seen.raw_px);
        points.emplace_back(p_world.x(), p_world.y(), p_world.z());
        rays.emplace_back(ray.x(), ray.y());
        names.push_back(seen.point);
      }
    }
    if (points.size() < kMinPoints) {
      return false;
    }
    PoseBlock& pose = window_.poses[frame];
    cv::Mat turn(3, 1, CV_64F, pose.data());
    cv::Mat shift(3, 1, CV_64F, pose.data() + 3);
    std::vector<int> inliers;
    const bool found = cv::solvePnPRansac(points, rays, cv::Matx33d(1, 0, 0, 0, 1, 0, 0, 0, 1), cv::noArray(), turn,
                                          shift, false, kSamples, static_cast<float>(kInlier_px / rig_.focal_px(0)),
                                          0.999, inliers, cv::SOLVEPNP_P3P);
    return found && inliers.size() >= kMinPoints;
  }

  const RigModel& rig_;
  const TrackWindow& tracks_;
  BundleWindow window_;
  std::vector<std::vector<Seen>> by_frame_;
};

}  // namespace

std::optional<BundleWindow> start_window(const RigModel& rig, const TrackWindow& tracks) {
  return Chain(rig, tracks).run();
}

}  // namespace kinetrace::self_calibration

#include "initial_guess.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <opencv2/calib3d.hpp>

namespace kinetrace::calibration {
namespace {

constexpr std::size_t kMinCorners = 4;
// In image widths: from 150 degrees of a fisheye lens to 10 of a long one.
constexpr std::array kFocals{0.2, 0.25, 0.32, 0.4, 0.5, 0.62, 0.78, 0.95, 1.2, 1.5, 1.9, 2.5, 3.5, 5.5};

Se3 pose_of(const cv::Mat& rotation_vector, const cv::Mat& translation) {
  return {so3_exp({rotation_vector.at<double>(0), rotation_vector.at<double>(1), rotation_vector.at<double>(2)}),
          {translation.at<double>(0), translation.at<double>(1), translation.at<double>(2)}};
}

hal::CameraModel without_distortion(Lens lens, int width_px, int height_px, double focal_px) {
  return {.lens = model_of(lens),
          .width_px = width_px,
          .height_px = height_px,
          .fx_px = focal_px,
          .fy_px = focal_px,
          .cx_px = (width_px - 1) / 2.0,
          .cy_px = (height_px - 1) / 2.0};
}

// A sample spread over all views.
std::vector<std::size_t> sample(std::size_t count) {
  constexpr std::size_t kMaxViews = 24;
  std::vector<std::size_t> chosen;
  const std::size_t take = std::min(count, kMaxViews);
  for (std::size_t i = 0; i < take; ++i) {
    chosen.push_back(i * count / take);
  }
  return chosen;
}

double distance(const Se3& a, const Se3& b) {
  // A radian counts as much as a metre, the order of magnitude of the distance to the target.
  return so3_log(a.rotation.transpose() * b.rotation).norm() + (a.translation - b.translation).norm();
}

struct Candidate {
  std::size_t view = 0;
  Se3 T_right_left;
};

// The candidate nearest to the others; distances are truncated, so that outliers do not dominate.
const Candidate* most_agreed(const std::vector<Candidate>& candidates) {
  const Candidate* best = nullptr;
  double least = std::numeric_limits<double>::max();
  for (const Candidate& candidate : candidates) {
    double sum = 0.0;
    for (const Candidate& other : candidates) {
      constexpr double kTruncation = 0.1;
      sum += std::min(distance(candidate.T_right_left, other.T_right_left), kTruncation);
    }
    if (sum < least) {
      least = sum;
      best = &candidate;
    }
  }
  return best;
}

}  // namespace

std::vector<Se3> plane_poses(const hal::CameraModel& camera, const Target& target, const std::vector<Corner>& corners) {
  std::vector<cv::Point3d> board;
  std::vector<cv::Point2d> rays;
  for (const Corner& corner : corners) {
    if (const auto ray = normalised_ray(camera, corner.px)) {
      const Eigen::Vector3d& p = target.points_m[static_cast<std::size_t>(corner.id)];
      board.emplace_back(p.x(), p.y(), p.z());
      rays.emplace_back(ray->x(), ray->y());
    }
  }
  if (board.size() < kMinCorners) {
    return {};
  }
  std::vector<cv::Mat> rotations;
  std::vector<cv::Mat> translations;
  try {
    cv::solvePnPGeneric(board, rays, cv::Matx33d(1, 0, 0, 0, 1, 0, 0, 0, 1), cv::noArray(), rotations, translations,
                        false, cv::SOLVEPNP_IPPE);
  } catch (const cv::Exception&) {
    return {};  // Collinear corners.
  }
  std::vector<Se3> poses;
  for (std::size_t i = 0; i < rotations.size(); ++i) {
    const Se3 pose = pose_of(rotations[i], translations[i]);
    if (pose.is_finite() && pose.translation.z() > 0.0) {
      poses.push_back(pose);
    }
  }
  return poses;
}

double reprojection_rms_px(const hal::CameraModel& camera, const Target& target, const Se3& T_cam_board,
                           const std::vector<Corner>& corners) {
  double sum = 0.0;
  for (const Corner& corner : corners) {
    const Eigen::Vector3d p_cam = T_cam_board * target.points_m[static_cast<std::size_t>(corner.id)];
    if (p_cam.z() <= 0.0) {
      return std::numeric_limits<double>::max();
    }
    sum += (camera.project(p_cam) - corner.px).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(std::max<std::size_t>(corners.size(), 1)));
}

std::optional<hal::CameraModel> guess_camera(Lens lens, int width_px, int height_px, const Target& target,
                                             std::span<const std::vector<Corner>> views) {
  std::optional<hal::CameraModel> best;
  double least = std::numeric_limits<double>::max();
  for (const double focal : kFocals) {
    const hal::CameraModel camera = without_distortion(lens, width_px, height_px, focal * width_px);
    double sum = 0.0;
    for (const std::size_t i : sample(views.size())) {
      const auto poses = plane_poses(camera, target, views[i]);
      // A view without any pose counts as a bad fit.
      const double worst_px = width_px;
      sum +=
          poses.empty() ? worst_px : std::min(worst_px, reprojection_rms_px(camera, target, poses.front(), views[i]));
    }
    if (!views.empty() && sum < least) {
      least = sum;
      best = camera;
    }
  }
  return best;
}

std::optional<StereoGuess> guess_poses(const hal::CameraModel& left, const hal::CameraModel& right,
                                       const Target& target, std::span<const BoardView> views) {
  std::vector<Candidate> candidates;
  std::vector<std::vector<Se3>> left_poses(views.size());
  for (std::size_t i = 0; i < views.size(); ++i) {
    left_poses[i] = plane_poses(left, target, views[i].left);
    const auto right_poses = plane_poses(right, target, views[i].right);
    if (!left_poses[i].empty() && !right_poses.empty()) {
      candidates.push_back({i, right_poses.front() * left_poses[i].front().inverse()});
    }
  }
  const Candidate* agreed = most_agreed(candidates);
  if (agreed == nullptr) {
    return std::nullopt;
  }
  StereoGuess guess{.T_right_left = agreed->T_right_left, .T_left_board = {}};
  for (std::size_t i = 0; i < views.size(); ++i) {
    // Of the two poses of a plane, the one confirmed by the other view.
    std::optional<Se3> best;
    double least = std::numeric_limits<double>::max();
    for (const Se3& pose : left_poses[i]) {
      const double rms = reprojection_rms_px(left, target, pose, views[i].left) +
                         reprojection_rms_px(right, target, guess.T_right_left * pose, views[i].right);
      if (rms < least) {
        least = rms;
        best = pose;
      }
    }
    guess.T_left_board.push_back(best);
  }
  return guess;
}

}  // namespace kinetrace::calibration

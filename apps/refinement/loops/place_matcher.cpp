#include "place_matcher.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <opencv2/calib3d.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "pose_information.hpp"
#include "revisits.hpp"

namespace kinetrace::batch {
namespace {

constexpr std::size_t kMaxCandidates = 2;
constexpr int kThumbnailWidth_px = 32;
constexpr int kMaxCorners = 3000;
constexpr int kFastThreshold = 7;
// A match must be clearly better than the second best (Lowe 2004).
constexpr float kRatio = 0.8F;
// A wrong match fits a pose from three others within 4 px with a probability of 10^-4: of 500, never nine.
constexpr float kSampleLimit_px = 4.0F;
constexpr int kMinSampled = 12;
constexpr std::size_t kMinAligned = 30;
constexpr int kPatch_px = 15;
constexpr int kPyramidLevels = 2;
constexpr float kMaxRowDifference_px = 1.0F;
// The same surfaces from nearly the same place: alignment must be as accurate as tracking, or it is another place.
constexpr double kMaxSigma_px = 0.5;
constexpr double kInlier_sigmas = 3.0;
// Repetitive structures (windows of a house) are further apart than the path can have drifted. Tolerance in addition to
// the drift, as a fraction of the depth.
constexpr double kTolerance_depths = 0.05;

cv::Mat copy_of(const GrayView& image) {
  cv::Mat copy(image.height, image.width, CV_8U);
  for (int y = 0; y < image.height; ++y) {
    std::copy_n(image.row(y), image.width, copy.ptr(y));
  }
  return copy;
}

cv::Mat thumbnail_of(const cv::Mat& image) {
  cv::Mat small;
  const int height_px = std::max(1, kThumbnailWidth_px * image.rows / image.cols);
  cv::resize(image, small, {kThumbnailWidth_px, height_px}, 0.0, 0.0, cv::INTER_AREA);
  small.convertTo(small, CV_32F);
  small -= cv::mean(small);
  return small / std::max(cv::norm(small), 1e-3);
}

/// Descriptors of the given corners, with the index of each in `class_id`; those too near the border are left out.
cv::Mat describe(const cv::Mat& image, std::vector<cv::KeyPoint>& corners) {
  constexpr float kOrbPatch_px = 31.0F;
  for (cv::KeyPoint& corner : corners) {
    corner.size = kOrbPatch_px;
    corner.angle = 0.0F;  // The camera has nearly the same orientation at both times.
    corner.octave = 0;
  }
  cv::Mat descriptors;
  cv::ORB::create()->compute(image, corners, descriptors);
  return descriptors;
}

std::vector<cv::KeyPoint> corners_of(const cv::Mat& image) {
  std::vector<cv::KeyPoint> corners;
  cv::FAST(image, corners, kFastThreshold);
  cv::KeyPointsFilter::retainBest(corners, kMaxCorners);
  return corners;
}

Eigen::Vector3d position_m(const StereoGeometry& geometry, const SeenPoint& point) {
  const Eigen::Vector3d px = point.px.cast<double>();
  return geometry.triangulate(px.x(), px.y(), px.x() - px.z());
}

bool is_inside(const cv::Point2f& px, const cv::Mat& image) {
  return px.x >= 0.0F && px.y >= 0.0F && px.x <= static_cast<float>(image.cols - 1) &&
         px.y <= static_cast<float>(image.rows - 1);
}

/// Tracks patches of one picture to another, starting from their expected positions.
std::vector<bool> align(const cv::Mat& from, const cv::Mat& to, const std::vector<cv::Point2f>& at,
                        std::vector<cv::Point2f>& found) {
  std::vector<std::uint8_t> status;
  cv::calcOpticalFlowPyrLK(from, to, at, found, status, cv::noArray(), {kPatch_px, kPatch_px}, kPyramidLevels,
                           {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 30, 0.01}, cv::OPTFLOW_USE_INITIAL_FLOW);
  std::vector<bool> is_found;
  for (std::size_t i = 0; i < at.size(); ++i) {
    is_found.push_back(status[i] != 0 && is_inside(found[i], to));
  }
  return is_found;
}

}  // namespace

Result<PlaceMatcher::View> PlaceMatcher::view_of(const Keyframe& keyframe) const {
  const Result<RectifiedPair> pair = read_(run_.camera[keyframe.row].frame);
  if (!pair) {
    return Unexpected(pair.error());
  }
  return View{copy_of(pair->left), copy_of(pair->right)};
}

Result<const PlaceMatcher::Place*> PlaceMatcher::place_of(const Keyframe& keyframe) {
  const auto known = places_.find(keyframe.row);
  if (known != places_.end()) {
    return &known->second;
  }
  const Result<View> view = view_of(keyframe);
  if (!view) {
    return Unexpected(view.error());
  }
  std::vector<cv::KeyPoint> corners;
  for (std::size_t i = 0; i < keyframe.points.size(); ++i) {
    const Eigen::Vector3f& px = keyframe.points[i].px;
    corners.emplace_back(px.x(), px.y(), 0.0F);
    corners.back().class_id = static_cast<int>(i);
  }
  Place place{thumbnail_of(view->left), {}, describe(view->left, corners)};
  for (const cv::KeyPoint& corner : corners) {
    place.described.push_back(static_cast<std::size_t>(corner.class_id));
  }
  return &places_.emplace(keyframe.row, std::move(place)).first->second;
}

std::optional<Se3> PlaceMatcher::coarse_pose(const Keyframe& then, const Place& place, const View& view_now) const {
  std::vector<cv::KeyPoint> corners = corners_of(view_now.left);
  const cv::Mat descriptors = describe(view_now.left, corners);
  if (place.described.size() < kMinSampled || corners.size() < kMinSampled) {
    return std::nullopt;
  }
  std::vector<std::vector<cv::DMatch>> matches;
  cv::BFMatcher(cv::NORM_HAMMING).knnMatch(place.descriptors, descriptors, matches, 2);
  std::vector<cv::Point3d> points_m;
  std::vector<cv::Point2d> seen_px;
  for (const std::vector<cv::DMatch>& match : matches) {
    if (match.size() == 2 && match[0].distance < kRatio * match[1].distance) {
      const std::size_t at = place.described[static_cast<std::size_t>(match[0].queryIdx)];
      const Eigen::Vector3d p_m = position_m(run_.rectified, then.points[at]);
      points_m.emplace_back(p_m.x(), p_m.y(), p_m.z());
      seen_px.emplace_back(corners[static_cast<std::size_t>(match[0].trainIdx)].pt);
    }
  }
  if (points_m.size() < kMinSampled) {
    return std::nullopt;
  }
  const StereoGeometry& geometry = run_.rectified;
  const cv::Matx33d camera(geometry.fx_px, 0.0, geometry.cx_px, 0.0, geometry.fy_px, geometry.cy_px, 0.0, 0.0, 1.0);
  cv::Vec3d turn;
  cv::Vec3d shift;
  std::vector<int> inliers;
  constexpr int kSamples = 300;
  constexpr double kConfidence = 0.999;
  if (!cv::solvePnPRansac(points_m, seen_px, camera, cv::noArray(), turn, shift, false, kSamples, kSampleLimit_px,
                          kConfidence, inliers, cv::SOLVEPNP_AP3P) ||
      inliers.size() < kMinSampled) {
    return std::nullopt;
  }
  return Se3{so3_exp({turn[0], turn[1], turn[2]}), {shift[0], shift[1], shift[2]}};
}

Result<std::optional<Loop>> PlaceMatcher::adjusted(const Keyframe& then, const Keyframe& now, const View& view_now,
                                                   const Se3& T_now_then) const {
  const Result<View> view_then = view_of(then);
  if (!view_then) {
    return Unexpected(view_then.error());
  }
  std::vector<const SeenPoint*> points;
  std::vector<cv::Point2f> at;
  std::vector<cv::Point2f> left;
  std::vector<cv::Point2f> right;
  for (const SeenPoint& point : then.points) {
    const Eigen::Vector3d p_now_m = T_now_then * position_m(run_.rectified, point);
    const Eigen::Vector3f px = p_now_m.z() > 0.0 ? run_.rectified.project(p_now_m).cast<float>().eval()
                                                 : Eigen::Vector3f::Constant(-1.0F).eval();
    if (is_inside({px.x(), px.y()}, view_now.left) && is_inside({px.z(), px.y()}, view_now.right)) {
      points.push_back(&point);
      at.emplace_back(point.px.x(), point.px.y());
      left.emplace_back(px.x(), px.y());
      right.emplace_back(px.z(), px.y());
    }
  }
  if (points.size() < kMinAligned) {
    return std::nullopt;
  }
  const std::vector<bool> is_left = align(view_then->left, view_now.left, at, left);
  const std::vector<bool> is_right = align(view_then->left, view_now.right, at, right);
  BodyProblem problem;
  problem.geometry = run_.rectified;
  problem.T_body_cam = {Se3{}, T_now_then.inverse()};
  problem.fixed_frames = {0};
  std::vector<SeenPoint> again;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (is_left[i] && is_right[i] && std::abs(left[i].y - right[i].y) < kMaxRowDifference_px) {
      problem.seen.push_back({0, points[i]->point_id, points[i]->px});
      again.push_back({1, points[i]->point_id, {left[i].x, 0.5F * (left[i].y + right[i].y), right[i].x}});
    }
  }
  problem.seen.insert(problem.seen.end(), again.begin(), again.end());
  if (again.size() < kMinAligned) {
    return std::nullopt;
  }
  const Result<BodyFit> fit = adjust_body(problem, options_);
  if (!fit) {
    return Unexpected(fit.error());
  }
  std::vector<Eigen::Vector3d> inliers_m;
  for (const RefinedPoint& point : fit->points) {
    if (point.error_px < kInlier_sigmas * fit->sigma_px && point.position_m.z() > 0.0) {
      inliers_m.push_back(point.position_m);
    }
  }
  if (fit->sigma_px > kMaxSigma_px || inliers_m.size() < std::max(kMinAligned, again.size() / 2)) {
    return std::nullopt;
  }
  return Loop{then.row, now.row, problem.T_body_cam[1], pose_information(run_.rectified, inliers_m, fit->sigma_px)};
}

bool PlaceMatcher::fits_path(const Loop& loop, const Keyframe& then, const Keyframe& now) const {
  const Se3 expected = T_world_cam_[then.row].inverse() * T_world_cam_[now.row];
  return (loop.T_from_to.translation - expected.translation).norm() <
         largest_drift_m(then, now) + kTolerance_depths * then.depth_m;
}

Result<std::optional<Loop>> PlaceMatcher::match(std::span<const Keyframe> keyframes, std::size_t now,
                                                std::span<const std::size_t> candidates) {
  const Result<const Place*> here = place_of(keyframes[now]);
  if (!here) {
    return Unexpected(here.error());
  }
  std::vector<std::pair<double, std::size_t>> alike;
  for (const std::size_t candidate : candidates) {
    const Result<const Place*> place = place_of(keyframes[candidate]);
    if (!place) {
      return Unexpected(place.error());
    }
    alike.emplace_back(-(*place)->thumbnail.dot((*here)->thumbnail), candidate);
  }
  std::sort(alike.begin(), alike.end());
  alike.resize(std::min(alike.size(), kMaxCandidates));
  const Result<View> view_now = view_of(keyframes[now]);
  if (!view_now) {
    return Unexpected(view_now.error());
  }
  for (const auto& [correlation, candidate] : alike) {
    const Keyframe& then = keyframes[candidate];
    const std::optional<Se3> T_now_then = coarse_pose(then, places_.at(then.row), *view_now);
    if (!T_now_then) {
      continue;
    }
    Result<std::optional<Loop>> loop = adjusted(then, keyframes[now], *view_now, *T_now_then);
    if (!loop || (*loop && fits_path(**loop, then, keyframes[now]))) {
      return loop;
    }
  }
  return std::nullopt;
}

}  // namespace kinetrace::batch

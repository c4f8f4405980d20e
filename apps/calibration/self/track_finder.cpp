#include "track_finder.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

namespace kinetrace::self_calibration {
namespace {

using features::AffineGate;
using features::AffinePlace;
using features::AffineTemplate;

constexpr int kPyramidLevels = 4;
constexpr double kReturn_px = 0.5;  // Largest distance of a match tracked back from its start.
constexpr double kPatchSigma_px = 4.0;
constexpr AffineGate kGate{.reach_px = 2.0, .correlation = 0.9};  // From the result of the coarse steps.
const cv::Size kCoarsePatch(15, 15);
const cv::TermCriteria kCriteria(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 20, 0.03);

GrayView view_of(const cv::Mat& image) {
  return {image.data, image.cols, image.rows, static_cast<int>(image.step)};
}

cv::Point2f to_opencv(const Eigen::Vector2d& p) {
  return {static_cast<float>(p.x()), static_cast<float>(p.y())};
}

struct Corner {
  float strength = 0.0F;
  int x = 0;
  int y = 0;
};

/// Local maxima of the smaller eigenvalue (Shi and Tomasi, CVPR 1994) above a fraction of the strongest, by strength.
std::vector<Corner> local_maxima(const cv::Mat& image, const cv::Mat& allowed) {
  constexpr double kPartOfStrong = 0.004;
  cv::Mat strength;
  cv::Mat widened;
  cv::cornerMinEigenVal(image, strength, 7, 3);
  cv::dilate(strength, widened, cv::Mat());
  double strongest = 0.0;
  cv::minMaxLoc(strength, nullptr, &strongest, nullptr, nullptr, allowed);
  std::vector<Corner> corners;
  for (int y = 0; y < strength.rows; ++y) {
    for (int x = 0; x < strength.cols; ++x) {
      const float s = strength.at<float>(y, x);
      if (allowed.at<std::uint8_t>(y, x) != 0 && s == widened.at<float>(y, x) && s > kPartOfStrong * strongest) {
        corners.push_back({s, x, y});
      }
    }
  }
  std::stable_sort(corners.begin(), corners.end(),
                   [](const Corner& a, const Corner& b) { return a.strength > b.strength; });
  return corners;
}

}  // namespace

bool TrackFinder::is_inside(int view, const Eigen::Vector2d& at) const {
  const cv::Mat& inside = warp_->inside(view);
  const auto x = static_cast<int>(std::lround(at.x()));
  const auto y = static_cast<int>(std::lround(at.y()));
  return x >= 0 && y >= 0 && x < inside.cols && y < inside.rows && inside.at<std::uint8_t>(y, x) != 0;
}

TrackFinder::Images TrackFinder::prepare(const StereoFrame& frame) const {
  Images images;
  images.left = warp_->warped(0, frame.left);
  images.right = warp_->warped(1, frame.right);
  cv::buildOpticalFlowPyramid(images.left, images.pyramid, kCoarsePatch, kPyramidLevels);
  return images;
}

void TrackFinder::add(const StereoFrame& frame, std::size_t place) {
  Images now = prepare(frame);
  window_.places.push_back(place);
  follow(now);
  find_new(now);
  match_right(now);
  record();
  before_ = std::move(now);
}

void TrackFinder::follow(const Images& now) {
  if (points_.empty()) {
    return;
  }
  std::vector<cv::Point2f> from;
  std::vector<cv::Point2f> to;
  for (const Point& point : points_) {
    from.push_back(to_opencv(point.left.position));
    to.push_back(to_opencv(point.left.position + point.flow_px));
  }
  std::vector<std::uint8_t> found;
  cv::calcOpticalFlowPyrLK(before_.pyramid, now.pyramid, from, to, found, cv::noArray(), kCoarsePatch, kPyramidLevels,
                           kCriteria, cv::OPTFLOW_USE_INITIAL_FLOW);
  std::vector<cv::Point2f> back = from;
  std::vector<std::uint8_t> returned;
  cv::calcOpticalFlowPyrLK(now.pyramid, before_.pyramid, to, back, returned, cv::noArray(), kCoarsePatch, 1, kCriteria,
                           cv::OPTFLOW_USE_INITIAL_FLOW);
  std::vector<Point> kept;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (found[i] == 0 || returned[i] == 0 || cv::norm(back[i] - from[i]) > kReturn_px) {
      continue;
    }
    Point& point = points_[i];
    const AffinePlace guess{{to[i].x, to[i].y}, point.left.shape};
    const auto place = point.patch.align(view_of(now.left), guess, kGate);
    if (place && is_inside(0, place->position)) {
      point.flow_px = place->position - point.left.position;
      if (point.right) {
        point.right->position += point.flow_px;
      }
      point.left = *place;
      kept.push_back(std::move(point));
    }
  }
  points_ = std::move(kept);
}

void TrackFinder::find_new(const Images& now) {
  constexpr int kColumns = 14;
  constexpr int kRows = 8;
  constexpr std::size_t kPerCell = 10;
  constexpr int kApart_px = 7;
  const cv::Size size = now.left.size();
  const auto cell_of = [&](double x, double y) {
    const int cell = static_cast<int>(y) * kRows / size.height * kColumns + static_cast<int>(x) * kColumns / size.width;
    return static_cast<std::size_t>(cell);
  };
  std::vector<std::size_t> count(static_cast<std::size_t>(kColumns) * kRows, 0);
  cv::Mat allowed = warp_->inside(0).clone();
  for (const Point& point : points_) {
    cv::circle(allowed, to_opencv(point.left.position), kApart_px, cv::Scalar(0), cv::FILLED);
    ++count[cell_of(point.left.position.x(), point.left.position.y())];
  }
  for (const Corner& corner : local_maxima(now.pyramid[0], allowed)) {
    std::size_t& in_cell = count[cell_of(corner.x, corner.y)];
    if (in_cell >= kPerCell || allowed.at<std::uint8_t>(corner.y, corner.x) == 0) {
      continue;
    }
    const Eigen::Vector2d at(corner.x, corner.y);
    if (const auto patch = AffineTemplate::make(view_of(now.left), at, kPatchSigma_px)) {
      cv::circle(allowed, {corner.x, corner.y}, kApart_px, cv::Scalar(0), cv::FILLED);
      ++in_cell;
      points_.push_back({window_.tracks.size(), *patch, {at}, Eigen::Vector2d::Zero(), std::nullopt});
      window_.tracks.emplace_back();
    }
  }
}

std::optional<Eigen::Vector2d> TrackFinder::search_row(const Images& now, const Eigen::Vector2d& left_px) const {
  constexpr int kRadius = AffineTemplate::kRadius_px;
  constexpr double kEnough = 0.8;
  const auto x = static_cast<int>(std::lround(left_px.x()));
  const auto y = static_cast<int>(std::lround(left_px.y()));
  const cv::Rect all({0, 0}, now.right.size());
  const cv::Rect patch(x - kRadius, y - kRadius, 2 * kRadius + 1, 2 * kRadius + 1);
  const int first = x - static_cast<int>(std::ceil(search_.most_disparity_px));
  const int last = x - static_cast<int>(std::floor(search_.least_disparity_px));
  const cv::Rect strip = cv::Rect(first - kRadius, patch.y - search_.rows_px, last - first + patch.width,
                                  patch.height + 2 * search_.rows_px) &
                         all;
  if ((patch & all) != patch || strip.width < patch.width || strip.height < patch.height) {
    return std::nullopt;
  }
  cv::Mat correlation;
  cv::matchTemplate(now.right(strip), now.left(patch), correlation, cv::TM_CCOEFF_NORMED);
  double best = 0.0;
  cv::Point place;
  cv::minMaxLoc(correlation, nullptr, &best, nullptr, &place);
  if (best < kEnough) {
    return std::nullopt;
  }
  return Eigen::Vector2d(strip.x + place.x + kRadius, strip.y + place.y + kRadius) - Eigen::Vector2d(x, y) + left_px;
}

void TrackFinder::match_right(const Images& now) {
  for (Point& point : points_) {
    std::optional<AffinePlace> guess = std::exchange(point.right, std::nullopt);
    if (!guess) {
      if (const auto found = search_row(now, point.left.position)) {
        guess = AffinePlace{*found, point.left.shape};
      }
    }
    if (guess) {
      const auto right = point.patch.align(view_of(now.right), *guess, kGate);
      if (right && is_inside(1, right->position)) {
        point.right = right;
      }
    }
  }
}

void TrackFinder::record() {
  const auto frame = static_cast<std::uint16_t>(window_.places.size() - 1);
  for (const Point& point : points_) {
    std::vector<Observation>& seen = window_.tracks[point.track].observations;
    if (seen.empty() && !point.right) {
      continue;
    }
    seen.push_back({0, frame, warp_->to_raw(0, point.left.position)});
    if (point.right) {
      seen.push_back({1, frame, warp_->to_raw(1, point.right->position)});
    }
  }
}

TrackWindow TrackFinder::take() {
  std::erase_if(window_.tracks, [](const Track& track) {
    return track.observations.empty() || track.observations.front().frame == track.observations.back().frame;
  });
  points_.clear();
  return std::exchange(window_, {});
}

}  // namespace kinetrace::self_calibration

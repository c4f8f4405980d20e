#include "marker_corners.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <set>

#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

namespace kinetrace::calibration {
namespace {

using Points = std::vector<cv::Point2f>;

cv::Point2f on_board(const Eigen::Vector3d& point_m) {
  return {static_cast<float>(point_m.x()), static_cast<float>(point_m.y())};
}

const Marker* marker_of(const Target& target, int id) {
  const auto found =
      std::find_if(target.markers.begin(), target.markers.end(), [id](const Marker& each) { return each.id == id; });
  return found == target.markers.end() ? nullptr : &*found;
}

double side_px(const SeenMarker& marker) {
  return cv::norm(marker.corners_px[0] - marker.corners_px[2]) / std::sqrt(2.0);
}

cv::Point2f centre(const std::array<cv::Point2f, 4>& corners) {
  return (corners[0] + corners[1] + corners[2] + corners[3]) / 4;
}

std::array<cv::Point2f, 4> board_corners(const Marker& marker) {
  std::array<cv::Point2f, 4> corners;
  std::transform(marker.corners_m.begin(), marker.corners_m.end(), corners.begin(), on_board);
  return corners;
}

// Tolerance, in marker sides, of a homography of the whole board, as distortion bends straight lines.
constexpr double kBending = 0.35;

// Homography from the board to the image by the markers' centres; empty with too few markers.
cv::Mat homography_of_centres(const Target& target, const std::vector<SeenMarker>& markers) {
  constexpr std::size_t kMinMarkers = 4;
  if (markers.size() < kMinMarkers) {
    return {};
  }
  Points board;
  Points image;
  double side = 0.0;
  for (const SeenMarker& marker : markers) {
    board.push_back(centre(board_corners(*marker_of(target, marker.id))));
    image.push_back(centre(marker.corners_px));
    side += side_px(marker) / static_cast<double>(markers.size());
  }
  return cv::findHomography(board, image, cv::RANSAC, kBending * side);
}

// With few markers, by their detected corners.
cv::Mat homography_of_corners(const Target& target, const std::vector<SeenMarker>& markers, double tolerance_px) {
  Points board;
  Points image;
  for (const SeenMarker& marker : markers) {
    const auto corners = board_corners(*marker_of(target, marker.id));
    board.insert(board.end(), corners.begin(), corners.end());
    image.insert(image.end(), marker.corners_px.begin(), marker.corners_px.end());
  }
  return cv::findHomography(board, image, cv::RANSAC, tolerance_px);
}

// Rotates the marker's corner order to fit the board best; false if no order fits.
bool fix_corner_order(const Target& target, const cv::Mat& homography, SeenMarker& marker) {
  const auto corners = board_corners(*marker_of(target, marker.id));
  Points predicted;
  cv::perspectiveTransform(Points(corners.begin(), corners.end()), predicted, homography);
  double least = 1e30;
  SeenMarker best = marker;
  for (int turn = 0; turn < 4; ++turn) {
    double worst = 0.0;
    for (std::size_t i = 0; i < predicted.size(); ++i) {
      worst = std::max(worst, cv::norm(predicted[i] - marker.corners_px[i]));
    }
    if (worst < least) {
      least = worst;
      best = marker;
    }
    std::rotate(marker.corners_px.begin(), marker.corners_px.begin() + 1, marker.corners_px.end());
  }
  const double side = side_px(marker);
  marker = best;
  return least < kBending * side;
}

// False for a marker whose corners disagree with its nearest neighbours: a black area beside it was taken for a part of
// it.
bool fits_neighbours(const Target& target, const std::vector<SeenMarker>& markers, const SeenMarker& marker) {
  constexpr std::size_t kNeighbours = 6;
  std::vector<const SeenMarker*> others;
  for (const SeenMarker& other : markers) {
    if (other.id != marker.id) {
      others.push_back(&other);
    }
  }
  const cv::Point2f middle = centre(marker.corners_px);
  const auto nearer = [&middle](const SeenMarker* a, const SeenMarker* b) {
    return cv::norm(centre(a->corners_px) - middle) < cv::norm(centre(b->corners_px) - middle);
  };
  const std::size_t count = std::min(kNeighbours, others.size());
  std::partial_sort(others.begin(), others.begin() + static_cast<std::ptrdiff_t>(count), others.end(), nearer);
  std::vector<SeenMarker> neighbours;
  for (std::size_t i = 0; i < count; ++i) {
    neighbours.push_back(*others[i]);
  }
  constexpr double kTolerance = 0.1;
  constexpr double kMinTolerance_px = 1.0;
  const double tolerance_px = std::max(kTolerance * side_px(marker), kMinTolerance_px);
  const cv::Mat homography = homography_of_corners(target, neighbours, tolerance_px);
  if (homography.empty()) {
    return false;
  }
  const auto corners = board_corners(*marker_of(target, marker.id));
  Points predicted;
  cv::perspectiveTransform(Points(corners.begin(), corners.end()), predicted, homography);
  for (std::size_t i = 0; i < predicted.size(); ++i) {
    if (cv::norm(predicted[i] - marker.corners_px[i]) > tolerance_px) {
      return false;
    }
  }
  return true;
}

// Expected place of a corner: predicted from the adjacent marker alone, so that distortion does not matter.
struct Expected {
  cv::Point2f px;
  double square_px = 0.0;  ///< Side of a square around it without another corner.
  int markers = 0;
};

void add_expectation(std::map<int, Expected>& expected, int id, const cv::Point2f& px, double square_px) {
  Expected& corner = expected[id];
  corner.px += px;
  corner.square_px = corner.markers == 0 ? square_px : std::min(corner.square_px, square_px);
  ++corner.markers;
}

// Corners of the tags themselves.
void expect_tag_corners(const Target& target, const SeenMarker& marker, std::map<int, Expected>& expected) {
  const double gap_px = side_px(marker) * std::min(target.marker_m / target.square_m, 1.0);
  for (std::size_t i = 0; i < marker.corners_px.size(); ++i) {
    add_expectation(expected, marker.id * 4 + static_cast<int>(i), marker.corners_px[i], gap_px);
  }
}

// Corners of the square around the marker.
void expect_square_corners(const Target& target, const SeenMarker& marker, std::map<int, Expected>& expected) {
  const Marker& printed = *marker_of(target, marker.id);
  const auto corners = board_corners(printed);
  const cv::Mat homography =
      cv::getPerspectiveTransform(std::vector<cv::Point2f>(corners.begin(), corners.end()),
                                  std::vector<cv::Point2f>(marker.corners_px.begin(), marker.corners_px.end()));
  const double inset_m = (target.square_m - target.marker_m) / 2;
  const auto column = static_cast<int>(std::lround((printed.corners_m[0].x() - inset_m) / target.square_m));
  const auto row = static_cast<int>(std::lround((printed.corners_m[0].y() - inset_m) / target.square_m));
  for (const auto& [right, down] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}}) {
    const int x = column + right;
    const int y = row + down;
    if (x < 0 || y < 0 || x >= target.columns - 1 || y >= target.rows - 1) {
      continue;
    }
    const int id = y * (target.columns - 1) + x;
    Points predicted;
    cv::perspectiveTransform(Points{on_board(target.points_m[static_cast<std::size_t>(id)])}, predicted, homography);
    // The refinement window must not reach the markers.
    add_expectation(expected, id, predicted.front(), 2 * inset_m / target.marker_m * side_px(marker));
  }
}

}  // namespace

std::vector<SeenMarker> consistent_markers(const Target& target, std::vector<SeenMarker> markers) {
  std::set<int> seen;
  std::erase_if(markers, [&](const SeenMarker& marker) {
    return marker_of(target, marker.id) == nullptr || !seen.insert(marker.id).second;
  });
  if (markers.size() < 2) {
    return {};
  }
  cv::Mat homography = homography_of_centres(target, markers);
  if (homography.empty()) {
    homography = homography_of_corners(target, markers, kBending * side_px(markers.front()));
  }
  if (homography.empty()) {
    return {};
  }
  std::erase_if(markers, [&](SeenMarker& marker) { return !fix_corner_order(target, homography, marker); });
  if (markers.size() < 2) {
    return {};
  }
  std::vector<SeenMarker> consistent;
  std::copy_if(markers.begin(), markers.end(), std::back_inserter(consistent),
               [&](const SeenMarker& marker) { return fits_neighbours(target, markers, marker); });
  return consistent;
}

std::vector<Corner> refined_corners(const Target& target, const std::vector<SeenMarker>& markers,
                                    const cv::Mat& image) {
  std::map<int, Expected> expected;
  for (const SeenMarker& marker : markers) {
    target.kind == TargetKind::kAprilGrid ? expect_tag_corners(target, marker, expected)
                                          : expect_square_corners(target, marker, expected);
  }
  std::vector<Corner> corners;
  const cv::TermCriteria until(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 60, 1e-3);
  for (const auto& [id, corner] : expected) {
    constexpr double kMaxHalf_px = 7.0;
    const double half_px = std::min(corner.square_px * 0.4, kMaxHalf_px);
    const cv::Point2f start = corner.px / static_cast<float>(corner.markers);
    const auto margin = static_cast<float>(half_px) + 2.0F;
    if (half_px < 2.0 || start.x < margin || start.y < margin || start.x > static_cast<float>(image.cols) - margin ||
        start.y > static_cast<float>(image.rows) - margin) {
      continue;
    }
    Points refined{start};
    const int half = static_cast<int>(half_px);
    cv::cornerSubPix(image, refined, {half, half}, {-1, -1}, until);
    if (cv::norm(refined.front() - start) < half_px) {
      corners.push_back({id, {refined.front().x, refined.front().y}});
    }
  }
  return corners;
}

}  // namespace kinetrace::calibration

#include "view_collector.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "initial_guess.hpp"

namespace kinetrace::calibration {
namespace {

constexpr std::size_t kMinCorners = 6;
constexpr double kTilted_rad = 15.0 * std::numbers::pi / 180.0;
constexpr double kEnoughTilt_rad = 12.0 * std::numbers::pi / 180.0;
constexpr std::size_t kMinTiltedViews = 3;
constexpr double kMinCoverage = 0.4;
constexpr double kGoodCoverage = 0.75;
constexpr double kGoodDistanceRatio = 1.5;

// Two views differ if one of these does.
constexpr double kShift = 0.07;
constexpr double kGrowth = 0.12;  // Of the size.
constexpr double kTurn_rad = 7.0 * std::numbers::pi / 180.0;

std::string percent(double part) {
  return std::to_string(static_cast<int>(std::lround(100.0 * part))) + " %";
}

// Cells of an image in which corners were seen.
class Coverage {
 public:
  Coverage(int width_px, int height_px) : width_px_(width_px), height_px_(height_px) {}

  void add(const std::vector<Corner>& corners) {
    for (const Corner& corner : corners) {
      const int column = static_cast<int>(corner.px.x() * ViewCollector::kCellColumns / width_px_);
      const int row = static_cast<int>(corner.px.y() * ViewCollector::kCellRows / height_px_);
      if (column >= 0 && row >= 0 && column < ViewCollector::kCellColumns && row < ViewCollector::kCellRows) {
        const int cell = row * ViewCollector::kCellColumns + column;
        seen_[static_cast<std::size_t>(cell)] = true;
      }
    }
  }
  [[nodiscard]] double part() const {
    return static_cast<double>(std::count(seen_.begin(), seen_.end(), true)) / static_cast<double>(seen_.size());
  }
  /// The emptiest of nine parts of the image: "top left".
  [[nodiscard]] std::string emptiest() const {
    constexpr std::array<const char*, 3> kRows{"top ", "", "bottom "};
    constexpr std::array<const char*, 3> kColumns{"left", "middle", "right"};
    std::array<int, 9> empty{};
    for (int i = 0; i < static_cast<int>(seen_.size()); ++i) {
      const int row = i / ViewCollector::kCellColumns * 3 / ViewCollector::kCellRows;
      const int column = i % ViewCollector::kCellColumns * 3 / ViewCollector::kCellColumns;
      const int ninth = 3 * row + column;
      empty[static_cast<std::size_t>(ninth)] += seen_[static_cast<std::size_t>(i)] ? 0 : 1;
    }
    const auto most = std::max_element(empty.begin(), empty.end()) - empty.begin();
    return std::string(kRows[static_cast<std::size_t>(most / 3)]) + kColumns[static_cast<std::size_t>(most % 3)];
  }

 private:
  int width_px_;
  int height_px_;
  std::array<bool, static_cast<std::size_t>(ViewCollector::kCellColumns) * ViewCollector::kCellRows> seen_{};
};

struct Direction {
  const char* hint;
  double (*of)(const Placement&);
};
// In the order of Assessment::tilted.
constexpr std::array<Direction, 4> kDirections{
    {{"tilt the target's upper edge away", [](const Placement& p) { return -p.tilt_rad.x(); }},
     {"tilt the target's lower edge away", [](const Placement& p) { return p.tilt_rad.x(); }},
     {"turn the target's left edge away", [](const Placement& p) { return p.tilt_rad.y(); }},
     {"turn the target's right edge away", [](const Placement& p) { return -p.tilt_rad.y(); }}}};

void add_tilts(const std::vector<Placement>& placements, Assessment& assessment) {
  std::size_t tilted = 0;
  for (const Placement& placement : placements) {
    assessment.largest_tilt_rad = std::max(assessment.largest_tilt_rad, placement.tilt_rad.norm());
    tilted += placement.tilt_rad.norm() > kEnoughTilt_rad ? 1U : 0U;
    for (std::size_t i = 0; i < kDirections.size(); ++i) {
      assessment.tilted[i] += kDirections[i].of(placement) > kTilted_rad ? 1 : 0;
    }
  }
  if (tilted < kMinTiltedViews) {
    const int degrees = static_cast<int>(std::lround(assessment.largest_tilt_rad * 180.0 / std::numbers::pi));
    assessment.refusals.push_back("the views are too flat: the target is tilted by " + std::to_string(degrees) +
                                  " deg at most; tilt it by 20 to 45 deg each way");
  }
  for (std::size_t i = 0; i < kDirections.size(); ++i) {
    if (assessment.tilted[i] == 0) {
      assessment.missing.emplace_back(kDirections[i].hint);
    }
  }
}

void add_distances(const std::vector<Placement>& placements, Assessment& assessment) {
  const auto nearer = [](const Placement& a, const Placement& b) { return a.distance_m < b.distance_m; };
  const auto [nearest, farthest] = std::minmax_element(placements.begin(), placements.end(), nearer);
  assessment.nearest_m = nearest->distance_m;
  assessment.farthest_m = farthest->distance_m;
  if (farthest->distance_m < kGoodDistanceRatio * nearest->distance_m) {
    assessment.missing.emplace_back("show the target nearer and farther away");
  }
}

void add_coverage(const char* image, const Coverage& coverage, double& part, Assessment& assessment) {
  part = coverage.part();
  if (part < kMinCoverage) {
    assessment.refusals.push_back(std::string("the target covers ") + percent(part) + " of the " + image +
                                  " image; move it through the whole image, first to the " + coverage.emptiest());
  }
  if (part < kGoodCoverage) {
    assessment.missing.push_back(std::string("move the target to the ") + coverage.emptiest() + " of the " + image +
                                 " image");
  }
}

}  // namespace

ViewCollector::ViewCollector(const Target& target, Lens lens, int width_px, int height_px)
    : target_(target), lens_(lens), width_px_(width_px), height_px_(height_px) {
  const double focal_px = width_px * (lens == Lens::kFisheye ? 0.4 : 0.8);
  camera_ = {.lens = model_of(lens),
             .width_px = width_px,
             .height_px = height_px,
             .fx_px = focal_px,
             .fy_px = focal_px,
             .cx_px = (width_px - 1) / 2.0,
             .cy_px = (height_px - 1) / 2.0};
}

Offer ViewCollector::offer(BoardView view) {
  const auto is_enough = [](const std::vector<Corner>& corners) { return corners.size() >= kMinCorners; };
  const bool is_in_left = is_enough(view.left);
  const bool is_in_right = is_enough(view.right);
  const std::optional<Placement> placement = is_in_left && is_in_right ? placement_of(view) : std::nullopt;
  Offer result = Offer::kTaken;
  if (is_in_left != is_in_right) {
    result = Offer::kOneImageOnly;
  } else if (!placement) {
    result = Offer::kNoTarget;
  } else if (views_.size() >= kMaxViews || !is_new(*placement)) {
    result = Offer::kSimilar;
  }
  ++counts_[static_cast<std::size_t>(result)];
  if (result == Offer::kTaken) {
    views_.push_back(std::move(view));
    placements_.push_back(*placement);
    refine_camera();
  }
  return result;
}

std::optional<Placement> ViewCollector::placement_of(const BoardView& view) const {
  const auto poses = plane_poses(camera_, target_, view.left);
  if (poses.empty()) {
    return std::nullopt;
  }
  Placement placement;
  placement.centre.setZero();
  for (const Corner& corner : view.left) {
    placement.centre += corner.px / static_cast<double>(view.left.size());
  }
  double spread = 0.0;
  for (const Corner& corner : view.left) {
    spread += (corner.px - placement.centre).squaredNorm() / static_cast<double>(view.left.size());
  }
  placement.centre = placement.centre.cwiseQuotient(Eigen::Vector2d(width_px_, height_px_));
  placement.size = std::sqrt(6.0 * spread / (static_cast<double>(width_px_) * height_px_));
  const Eigen::Vector3d normal = poses.front().rotation.col(2);
  placement.tilt_rad = {-std::atan2(normal.y(), normal.z()), std::atan2(normal.x(), normal.z())};
  placement.distance_m = poses.front().translation.norm();
  return placement;
}

bool ViewCollector::is_new(const Placement& placement) const {
  return std::none_of(placements_.begin(), placements_.end(), [&placement](const Placement& other) {
    return (placement.centre - other.centre).cwiseAbs().maxCoeff() < kShift &&
           std::abs(placement.size - other.size) < kGrowth * other.size &&
           (placement.tilt_rad - other.tilt_rad).cwiseAbs().maxCoeff() < kTurn_rad;
  });
}

// Repeated whenever the number of views has grown by half, as tilts depend on the focal length.
void ViewCollector::refine_camera() {
  constexpr std::size_t kFirst = 4;
  if (views_.size() < kFirst || 2 * views_.size() < 3 * views_of_camera_) {
    return;
  }
  views_of_camera_ = views_.size();
  std::vector<std::vector<Corner>> left;
  for (const BoardView& view : views_) {
    left.push_back(view.left);
  }
  camera_ = guess_camera(lens_, width_px_, height_px_, target_, left).value_or(camera_);
  for (std::size_t i = 0; i < views_.size(); ++i) {
    placements_[i] = placement_of(views_[i]).value_or(placements_[i]);
  }
}

Assessment ViewCollector::assess() const {
  Assessment assessment;
  assessment.views = views_.size();
  if (views_.size() < kMinViews) {
    const std::size_t similar = count(Offer::kSimilar);
    std::string refusal =
        std::to_string(views_.size()) + " views are too few, at least " + std::to_string(kMinViews) + " are needed";
    if (similar > 2 * views_.size()) {
      refusal += "; " + std::to_string(similar) + " more were too similar to them: move and tilt the target more";
    } else if (count(Offer::kOneImageOnly) > views_.size()) {
      refusal += "; " + std::to_string(count(Offer::kOneImageOnly)) +
                 " more show the target in one image only: hold it where both cameras see it";
    } else {
      refusal += "; show the target longer, all of it in both images";
    }
    assessment.refusals.push_back(std::move(refusal));
  }
  if (views_.empty()) {
    assessment.missing.emplace_back("show the target to both cameras");
    return assessment;
  }
  Coverage left(width_px_, height_px_);
  Coverage right(width_px_, height_px_);
  for (const BoardView& view : views_) {
    left.add(view.left);
    right.add(view.right);
  }
  add_tilts(placements_, assessment);
  add_coverage("left", left, assessment.left_coverage, assessment);
  add_coverage("right", right, assessment.right_coverage, assessment);
  add_distances(placements_, assessment);
  if (views_.size() < kGoodViews) {
    assessment.missing.push_back("show it in " + std::to_string(kGoodViews - views_.size()) + " more places");
  }
  return assessment;
}

}  // namespace kinetrace::calibration

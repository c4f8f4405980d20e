// Selects views for calibration, and names the missing ones.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "detector.hpp"
#include "kinetrace/hal/rig_calibration.hpp"
#include "lens.hpp"

namespace kinetrace::calibration {

/// Outcome of offering a pair of images.
enum class Offer : std::uint8_t {
  kTaken,
  kNoTarget,      ///< In neither image.
  kOneImageOnly,  ///< The other image does not show enough of it.
  kSimilar,       ///< Nearly the same as a view taken before.
};

/// Placement of the target in a view.
struct Placement {
  Eigen::Vector2d centre;    ///< In the left image, relative to its size.
  double size = 0.0;         ///< Side of a square with the target's area, relative to the image's.
  Eigen::Vector2d tilt_rad;  ///< About the image's x axis and about its y axis; 0 where it faces the camera.
  double distance_m = 0.0;
};

/// Coverage of the views taken.
struct Assessment {
  std::size_t views = 0;
  double left_coverage = 0.0;  ///< Fraction of the image's cells in which corners were seen.
  double right_coverage = 0.0;
  std::array<int, 4> tilted{};  ///< Views that tilt away at the top, at the bottom, at the left, at the right.
  double largest_tilt_rad = 0.0;
  double nearest_m = 0.0;
  double farthest_m = 0.0;
  /// Views to show next, the most important first. Empty: nothing is missing.
  std::vector<std::string> missing;
  /// Reasons why these views are insufficient, with remedies; empty if sufficient.
  std::vector<std::string> refusals;
};

class ViewCollector {
 public:
  static constexpr std::size_t kMinViews = 10;   ///< Fewer are refused.
  static constexpr std::size_t kGoodViews = 25;  ///< This many are asked for.
  static constexpr std::size_t kMaxViews = 120;  ///< More only take time.
  static constexpr int kCellColumns = 8;
  static constexpr int kCellRows = 6;

  ViewCollector(const Target& target, Lens lens, int width_px, int height_px);

  Offer offer(BoardView view);

  [[nodiscard]] const std::vector<BoardView>& views() const noexcept { return views_; }
  [[nodiscard]] Assessment assess() const;
  /// Offered pairs of images, by outcome.
  [[nodiscard]] std::size_t count(Offer offer) const { return counts_[static_cast<std::size_t>(offer)]; }

 private:
  [[nodiscard]] std::optional<Placement> placement_of(const BoardView& view) const;
  [[nodiscard]] bool is_new(const Placement& placement) const;
  void refine_camera();

  const Target& target_;
  Lens lens_;
  int width_px_;
  int height_px_;
  hal::CameraModel camera_;  ///< Good enough to determine the target's tilt.
  std::size_t views_of_camera_ = 0;
  std::vector<BoardView> views_;
  std::vector<Placement> placements_;
  std::array<std::size_t, 4> counts_{};
};

}  // namespace kinetrace::calibration

// Chooses the views to calibrate from, and says which are still missing.
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

/// What became of a pair of images.
enum class Offer : std::uint8_t {
  kTaken,
  kNoTarget,      ///< In neither image.
  kOneImageOnly,  ///< The other image does not show enough of it.
  kSimilar,       ///< Another view that was taken shows nearly the same.
};

/// How the target stands in a view.
struct Placement {
  Eigen::Vector2d centre;    ///< In the left image, in parts of its size.
  double size = 0.0;         ///< Side of a square as large as the target appears, in parts of the image's.
  Eigen::Vector2d tilt_rad;  ///< About the image's x axis and about its y axis; 0 where it faces the camera.
  double distance_m = 0.0;
};

/// What the views that were taken cover.
struct Assessment {
  std::size_t views = 0;
  double left_coverage = 0.0;  ///< Part of the image's cells in which corners were seen.
  double right_coverage = 0.0;
  std::array<int, 4> tilted{};  ///< Views that tilt away at the top, at the bottom, at the left, at the right.
  double largest_tilt_rad = 0.0;
  double nearest_m = 0.0;
  double farthest_m = 0.0;
  /// What to show next, the most important first. Empty: nothing is missing.
  std::vector<std::string> missing;
  /// Why these views must not be calibrated from, with what to do; empty: they may.
  std::vector<std::string> refusals;
};

class ViewCollector {
 public:
  static constexpr std::size_t kMinViews = 10;   ///< Fewer are refused.
  static constexpr std::size_t kGoodViews = 25;  ///< So many are asked for.
  static constexpr std::size_t kMaxViews = 120;  ///< More add nothing but time.
  static constexpr int kCellColumns = 8;
  static constexpr int kCellRows = 6;

  ViewCollector(const Target& target, Lens lens, int width_px, int height_px);

  Offer offer(BoardView view);

  [[nodiscard]] const std::vector<BoardView>& views() const noexcept { return views_; }
  [[nodiscard]] Assessment assess() const;
  /// Pairs of images that were offered, by what became of them.
  [[nodiscard]] std::size_t count(Offer offer) const { return counts_[static_cast<std::size_t>(offer)]; }

 private:
  [[nodiscard]] std::optional<Placement> placement_of(const BoardView& view) const;
  [[nodiscard]] bool is_new(const Placement& placement) const;
  void refine_camera();

  const Target& target_;
  Lens lens_;
  int width_px_;
  int height_px_;
  hal::CameraModel camera_;  ///< Good enough to tell how the target is tilted.
  std::size_t views_of_camera_ = 0;
  std::vector<BoardView> views_;
  std::vector<Placement> placements_;
  std::array<std::size_t, 4> counts_{};
};

}  // namespace kinetrace::calibration

// Shift of a region between two images, by matching its pixels.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include <Eigen/Core>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/fixed_vector.hpp"
#include "kinetrace/core/image_view.hpp"

namespace kinetrace::segmentation {

/// An image and its halves.
class ImagePyramid {
 public:
  static constexpr int kLevels = 5;

  ImagePyramid() = default;
  ImagePyramid(int width, int height, Arena& arena);

  /// Copies `image`: of the pyramid's size, or empty.
  void fill(GrayView image) noexcept;
  [[nodiscard]] bool empty() const noexcept { return !filled_; }
  /// Level 0: full size. Each pixel of a level is the mean of four of the level before.
  [[nodiscard]] GrayView level(int level) const noexcept { return levels_[static_cast<std::size_t>(level)]; }

 private:
  std::array<MutableGrayView, kLevels> levels_;
  bool filled_ = false;
};

/// Prediction of a region's shift.
struct PredictedShift {
  Eigen::Vector2f mean_px{0.F, 0.F};
  float sigma_px = 1.F;  ///< Standard deviation of each coordinate, above 0.
};

/// Finds the shift of regions that are too plain or too small for features, coarse to fine: the most probable one given
/// the differences of grey levels and a prediction.
class RegionMatch {
 public:
  RegionMatch() = default;
  explicit RegionMatch(Arena& arena);

  /// Shift in pixels of the pixels `label` of `drawn` inside `box_px`, from `earlier` to `now`. All have the same size.
  /// None: a pyramid is empty.
  [[nodiscard]] std::optional<Eigen::Vector2f> shift_px(const ImagePyramid& earlier, const ImagePyramid& now,
                                                        ImageView<const std::uint16_t> drawn, std::uint16_t label,
                                                        const PixelBox& box_px,
                                                        const PredictedShift& predicted) noexcept;

 private:
  struct Sample {
    std::int16_t x = 0;
    std::int16_t y = 0;
    std::int16_t grey = 0;
  };
  void take_samples(GrayView earlier, int level, ImageView<const std::uint16_t> drawn, std::uint16_t label,
                    const PixelBox& box_px) noexcept;
  [[nodiscard]] float log_likelihood(GrayView now, int shift_x, int shift_y) const noexcept;

  FixedVector<Sample> samples_;  ///< Of the level that is matched.
};

}  // namespace kinetrace::segmentation

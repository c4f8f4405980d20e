// New corners where the image has texture and no feature yet.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <Eigen/Core>

#include "kernel_types.hpp"
#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/fixed_vector.hpp"
#include "kinetrace/core/image_view.hpp"
#include "kinetrace/core/workers.hpp"
#include "kinetrace/features/feature_config.hpp"

namespace kinetrace::features {

struct Corner {
  float eigenvalue = 0.F;  ///< Smaller one of the gradient matrix, (gray / px)^2; 0 means none.
  std::uint16_t x = 0;
  std::uint16_t y = 0;
  std::uint8_t body = 0;
  bool is_left_of_centre = false;  ///< On which side of its pixel's centre the corner lies.

  /// To half a column, where a patch of an even number of columns samples whole pixels. On the corner's own side: with
  /// all on one side, blur in one of two images would shift all matches alike, by hundredths of a pixel.
  [[nodiscard]] Eigen::Vector2f position_px() const noexcept {
    return {static_cast<float>(x) + (is_left_of_centre ? -0.5F : 0.5F), static_cast<float>(y)};
  }
};

/// Half-size map of the surroundings of features.
class OccupancyMap {
 public:
  OccupancyMap() = default;
  OccupancyMap(Arena& arena, int width_px, int height_px, int min_distance_px);

  void clear() noexcept;
  void add(const Eigen::Vector2f& position_px) noexcept;
  /// True within the minimum distance of a feature.
  [[nodiscard]] bool near(float x_px, float y_px) const noexcept;
  /// True practically on top of a feature.
  [[nodiscard]] bool coincides(float x_px, float y_px) const noexcept;

 private:
  MutableGrayView map_;
  int radius_ = 0;
};

class CornerFinder {
 public:
  CornerFinder() = default;
  CornerFinder(const FeatureConfig& config, Arena& arena, int width_px, int height_px);

  /// Marks the bucket around a live feature as taken.
  void occupy(const Eigen::Vector2f& position_px, std::uint8_t body) noexcept;
  /// Frees all buckets.
  void clear() noexcept;

  /// The strongest corner of every free bucket, not near a feature of `occupancy`: objects first, then background, each
  /// in descending strength. `workers` may be null.
  [[nodiscard]] std::span<const Corner> find(const Plane& image, LabelView labels, const OccupancyMap& occupancy,
                                             Workers* workers) noexcept;

 private:
  /// Number of bands of rows in which the image is searched, independent of the workers.
  static constexpr std::size_t kBands = 2;

  /// A grid of square buckets over the image.
  struct Grid {
    std::array<std::span<Corner>, kBands> best;  ///< By band, since a bucket may lie in both.
    std::span<std::uint8_t> taken;               ///< 1 + body of a feature in the bucket, 0 when free.
    int columns = 0;
    int size_px = 1;
    [[nodiscard]] std::size_t index(int x, int y) const noexcept {
      return static_cast<std::size_t>(y / size_px) * static_cast<std::size_t>(columns) +
             static_cast<std::size_t>(x / size_px);
    }
  };
  /// Scratch memory of a band's search.
  struct Scratch {
    std::span<std::int32_t> sums_xx;
    std::span<std::int32_t> sums_xy;
    std::span<std::int32_t> sums_yy;
    std::span<float> eigenvalue_rows;
    std::span<std::uint16_t> columns;
    std::size_t row_stride = 0;
    [[nodiscard]] float* eigenvalues(int y) const noexcept;
  };
  /// Input of a search.
  struct Search {
    const Plane& image;
    LabelView labels;
    const OccupancyMap& occupancy;
    float threshold = 0.F;
  };
  [[nodiscard]] static Grid take_grid(Arena& arena, int width_px, int height_px, int size_px);
  [[nodiscard]] static Scratch take_scratch(Arena& arena, int width_px);
  void search_band(const Search& search, std::size_t band) noexcept;
  static void eigenvalue_row(const Plane& image, int y, const Scratch& scratch) noexcept;
  void offer_row(const Search& search, int y, int count, std::size_t band) noexcept;
  void collect(const Grid& grid) noexcept;

  float background_threshold_ = 0.F;
  float object_threshold_ = 0.F;
  Grid background_;
  Grid objects_;
  std::array<Scratch, kBands> scratch_;
  FixedVector<Corner> corners_;
};

}  // namespace kinetrace::features

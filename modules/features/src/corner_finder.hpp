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
};

/// Which places are taken: a half-size map of the surroundings of features.
class OccupancyMap {
 public:
  OccupancyMap() = default;
  OccupancyMap(Arena& arena, int width_px, int height_px, int min_distance_px);

  void clear() noexcept;
  void add(const Eigen::Vector2f& position_px) noexcept;
  /// Within the minimum distance of a feature.
  [[nodiscard]] bool near(float x_px, float y_px) const noexcept;
  /// Practically on top of a feature.
  [[nodiscard]] bool upon(float x_px, float y_px) const noexcept;

 private:
  MutableGrayView map_;
  int radius_ = 0;
};

class CornerFinder {
 public:
  CornerFinder() = default;
  CornerFinder(const FeatureConfig& config, Arena& arena, int width_px, int height_px);

  /// Declares the bucket around a live feature taken.
  void occupy(const Eigen::Vector2f& position_px, std::uint8_t body) noexcept;
  /// All buckets are free again.
  void clear() noexcept;

  /// The strongest corner of every free bucket, not near anything in `occupancy`: objects first, then background, each
  /// from strong to weak. `workers` may be null.
  [[nodiscard]] std::span<const Corner> find(const Plane& image, LabelView labels, const OccupancyMap& occupancy,
                                             Workers* workers) noexcept;

 private:
  /// The image is searched in so many bands of rows, whoever searches them.
  static constexpr std::size_t kBands = 2;

  /// A grid of square buckets over the image.
  struct Grid {
    std::array<std::span<Corner>, kBands> best;  ///< By band: a bucket may lie in both.
    std::span<std::uint8_t> taken;               ///< 1 + body of a feature in the bucket, 0 when free.
    int columns = 0;
    int size_px = 1;
    [[nodiscard]] std::size_t index(int x, int y) const noexcept {
      return static_cast<std::size_t>(y / size_px) * static_cast<std::size_t>(columns) +
             static_cast<std::size_t>(x / size_px);
    }
  };
  /// What the search of a band needs for itself.
  struct Scratch {
    std::span<std::int32_t> sums_xx;
    std::span<std::int32_t> sums_xy;
    std::span<std::int32_t> sums_yy;
    std::span<float> eigenvalue_rows;
    std::span<std::uint16_t> columns;
    std::size_t row_stride = 0;
    [[nodiscard]] float* eigenvalues(int y) const noexcept;
  };
  /// What is searched.
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

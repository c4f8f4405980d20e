#include "corner_finder.hpp"

#include <algorithm>
#include <cmath>

#include "kernels.hpp"

namespace kinetrace::features {
namespace {

// A corner's patch, with a pixel to spare for its gradients, lies in the image.
constexpr int kBorderX = kPatchWidth / 2 + 2;
constexpr int kBorderY = kPatchHeight / 2 + 2;
constexpr int kWindowRadius = 2;
constexpr int kRows = 3;
// Vector loads reach this far beyond the columns in use.
constexpr int kSpill = 16;
// Features closer than this share their patch and say the same twice.
constexpr int kUponRadius = 1;
constexpr std::uint8_t kNear = 1;
constexpr std::uint8_t kUpon = 2;

int halved(float v) noexcept {
  return static_cast<int>(v * 0.5F);
}

bool stronger(const Corner& a, const Corner& b) noexcept {
  if (a.eigenvalue != b.eigenvalue) {
    return a.eigenvalue > b.eigenvalue;
  }
  return a.y != b.y ? a.y < b.y : a.x < b.x;
}

bool has_objects(LabelView labels) noexcept {
  for (int y = 0; y < labels.height; ++y) {
    const std::uint8_t* const row = labels.row(y);
    if (std::any_of(row, row + labels.width, [](std::uint8_t label) { return label != kBackgroundLabel; })) {
      return true;
    }
  }
  return false;
}

}  // namespace

OccupancyMap::OccupancyMap(Arena& arena, int width_px, int height_px, int min_distance_px)
    : map_(take_image<std::uint8_t>(arena, (width_px + 1) / 2, (height_px + 1) / 2)),
      radius_(std::max(1, min_distance_px / 2)) {}

void OccupancyMap::clear() noexcept {
  std::fill_n(map_.data, static_cast<std::size_t>(map_.stride) * static_cast<std::size_t>(map_.height),
              std::uint8_t{0});
}

void OccupancyMap::add(const Eigen::Vector2f& position_px) noexcept {
  const int x = halved(position_px.x());
  const int y = halved(position_px.y());
  for (int row = std::max(0, y - radius_); row <= std::min(map_.height - 1, y + radius_); ++row) {
    std::uint8_t* const pixels = map_.row(row);
    for (int column = std::max(0, x - radius_); column <= std::min(map_.width - 1, x + radius_); ++column) {
      const bool upon = std::abs(row - y) <= kUponRadius && std::abs(column - x) <= kUponRadius;
      pixels[column] = static_cast<std::uint8_t>(pixels[column] | kNear | (upon ? kUpon : 0));
    }
  }
}

bool OccupancyMap::near(float x_px, float y_px) const noexcept {
  return (map_.at(halved(x_px), halved(y_px)) & kNear) != 0;
}

bool OccupancyMap::upon(float x_px, float y_px) const noexcept {
  return (map_.at(halved(x_px), halved(y_px)) & kUpon) != 0;
}

CornerFinder::CornerFinder(const FeatureConfig& config, Arena& arena, int width_px, int height_px)
    : background_threshold_(config.min_corner_strength * config.min_corner_strength),
      object_threshold_(config.min_object_corner_strength * config.min_object_corner_strength),
      background_(take_grid(arena, width_px, height_px, config.bucket_px)),
      objects_(take_grid(arena, width_px, height_px, config.object_bucket_px)) {
  const std::size_t row = static_cast<std::size_t>(width_px) + 2 * std::size_t{kSpill};
  sums_xx_ = arena.take<std::int32_t>(row);
  sums_xy_ = arena.take<std::int32_t>(row);
  sums_yy_ = arena.take<std::int32_t>(row);
  eigenvalue_stride_ = row;
  eigenvalue_rows_ = arena.take<float>(row * kRows);
  columns_ = arena.take<std::uint16_t>(row);
  const auto buckets = [](const FeatureConfig& c, int w, int h) {
    const auto count = [](int length, int size) { return static_cast<std::size_t>((length + size - 1) / size); };
    return count(w, c.bucket_px) * count(h, c.bucket_px) + count(w, c.object_bucket_px) * count(h, c.object_bucket_px);
  };
  corners_ = FixedVector<Corner>(arena, buckets(config, width_px, height_px));
}

CornerFinder::Grid CornerFinder::take_grid(Arena& arena, int width_px, int height_px, int size_px) {
  Grid grid;
  grid.size_px = size_px;
  grid.columns = (width_px + size_px - 1) / size_px;
  const std::size_t count =
      static_cast<std::size_t>(grid.columns) * static_cast<std::size_t>((height_px + size_px - 1) / size_px);
  grid.best = arena.take<Corner>(count);
  grid.taken = arena.take<std::uint8_t>(count);
  return grid;
}

void CornerFinder::clear() noexcept {
  for (Grid* grid : {&background_, &objects_}) {
    std::fill(grid->best.begin(), grid->best.end(), Corner{});
    std::fill(grid->taken.begin(), grid->taken.end(), std::uint8_t{0});
  }
}

void CornerFinder::occupy(const Eigen::Vector2f& position_px, std::uint8_t body) noexcept {
  Grid& grid = body == kBackgroundLabel ? background_ : objects_;
  grid.taken[grid.index(static_cast<int>(position_px.x()), static_cast<int>(position_px.y()))] =
      static_cast<std::uint8_t>(body + 1);
}

std::span<const Corner> CornerFinder::find(const Plane& image, LabelView labels,
                                           const OccupancyMap& occupancy) noexcept {
  const int first_row = kBorderY;
  const int last_row = image.height - 1 - kBorderY;
  const int first_column = kBorderX;
  const int last_column = image.width - 1 - kBorderX;
  const bool objects_present = has_objects(labels);
  const float threshold = objects_present ? std::min(background_threshold_, object_threshold_) : background_threshold_;

  for (std::span<std::int32_t> sums : {sums_xx_, sums_xy_, sums_yy_}) {
    std::fill(sums.begin(), sums.end(), 0);
  }
  for (int y = first_row - 1 - kWindowRadius; y < first_row - 1 + kWindowRadius; ++y) {
    kernels().corner.accumulate_row(image, y, 1, sums_xx_.data() + kSpill, sums_xy_.data() + kSpill,
                                    sums_yy_.data() + kSpill);
  }
  eigenvalue_row(image, first_row - 1);
  eigenvalue_row(image, first_row);
  for (int y = first_row; y <= last_row; ++y) {
    eigenvalue_row(image, y + 1);
    const int count = kernels().corner.find_maxima(eigenvalues(y - 1), eigenvalues(y), eigenvalues(y + 1), first_column,
                                                   last_column + 1, threshold, columns_.data());
    offer_row(y, count, labels, occupancy);
  }
  corners_.clear();
  collect(objects_);
  collect(background_);
  return corners_.span();
}

float* CornerFinder::eigenvalues(int y) noexcept {
  return eigenvalue_rows_.data() + static_cast<std::size_t>(y % kRows) * eigenvalue_stride_ + kSpill;
}

void CornerFinder::eigenvalue_row(const Plane& image, int y) noexcept {
  std::int32_t* const xx = sums_xx_.data() + kSpill;
  std::int32_t* const xy = sums_xy_.data() + kSpill;
  std::int32_t* const yy = sums_yy_.data() + kSpill;
  kernels().corner.accumulate_row(image, y + kWindowRadius, 1, xx, xy, yy);
  kernels().corner.eigenvalue_row(xx, xy, yy, 0, image.width, eigenvalues(y));
  kernels().corner.accumulate_row(image, y - kWindowRadius, -1, xx, xy, yy);
}

void CornerFinder::offer_row(int y, int count, LabelView labels, const OccupancyMap& occupancy) noexcept {
  const float* const row = eigenvalues(y);
  for (int i = 0; i < count; ++i) {
    const int x = columns_[static_cast<std::size_t>(i)];
    const std::uint8_t body = labels.empty() ? kBackgroundLabel : labels.at(x, y);
    if (body == kIgnoreLabel) {
      continue;
    }
    const bool background = body == kBackgroundLabel;
    Grid& grid = background ? background_ : objects_;
    const std::size_t bucket = grid.index(x, y);
    Corner& best = grid.best[bucket];
    if (row[x] >= (background ? background_threshold_ : object_threshold_) && row[x] > best.eigenvalue &&
        grid.taken[bucket] != body + 1 && !occupancy.near(static_cast<float>(x), static_cast<float>(y))) {
      best = {row[x], static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y), body};
    }
  }
}

void CornerFinder::collect(const Grid& grid) noexcept {
  const std::size_t before = corners_.size();
  for (const Corner& corner : grid.best) {
    if (corner.eigenvalue > 0.F) {
      // Capacity is the number of buckets of both grids.
      static_cast<void>(corners_.push_back(corner));
    }
  }
  std::sort(corners_.begin() + before, corners_.end(), stronger);
}

}  // namespace kinetrace::features

#include "corner_finder.hpp"

#include <algorithm>
#include <cmath>

#include "kernels.hpp"

namespace kinetrace::features {
namespace {

// A corner's patch lies in the image, with a pixel to spare for its gradients.
constexpr int kBorderX = kPatchWidth / 2 + 2;
constexpr int kBorderY = kPatchHeight / 2 + 2;
constexpr int kWindowRadius = 2;
constexpr int kRows = 3;
// Vector loads reach this far beyond the columns in use.
constexpr int kSpill = 16;
// Features closer than this share their patch and are redundant.
constexpr int kCoincidentRadius = 1;
constexpr std::uint8_t kNear = 1;
constexpr std::uint8_t kCoincident = 2;

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
      const bool coincides = std::abs(row - y) <= kCoincidentRadius && std::abs(column - x) <= kCoincidentRadius;
      pixels[column] = static_cast<std::uint8_t>(pixels[column] | kNear | (coincides ? kCoincident : 0));
    }
  }
}

bool OccupancyMap::near(float x_px, float y_px) const noexcept {
  return (map_.at(halved(x_px), halved(y_px)) & kNear) != 0;
}

bool OccupancyMap::coincides(float x_px, float y_px) const noexcept {
  return (map_.at(halved(x_px), halved(y_px)) & kCoincident) != 0;
}

CornerFinder::CornerFinder(const FeatureConfig& config, Arena& arena, int width_px, int height_px)
    : background_threshold_(config.min_corner_strength * config.min_corner_strength),
      object_threshold_(config.min_object_corner_strength * config.min_object_corner_strength),
      background_(take_grid(arena, width_px, height_px, config.bucket_px)),
      objects_(take_grid(arena, width_px, height_px, config.object_bucket_px)) {
  for (Scratch& scratch : scratch_) {
    scratch = take_scratch(arena, width_px);
  }
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
  for (std::span<Corner>& best : grid.best) {
    best = arena.take<Corner>(count);
  }
  grid.taken = arena.take<std::uint8_t>(count);
  return grid;
}

CornerFinder::Scratch CornerFinder::take_scratch(Arena& arena, int width_px) {
  const std::size_t row = static_cast<std::size_t>(width_px) + 2 * std::size_t{kSpill};
  return {.sums_xx = arena.take<std::int32_t>(row),
          .sums_xy = arena.take<std::int32_t>(row),
          .sums_yy = arena.take<std::int32_t>(row),
          .eigenvalue_rows = arena.take<float>(row * kRows),
          .columns = arena.take<std::uint16_t>(row),
          .row_stride = row};
}

void CornerFinder::clear() noexcept {
  for (Grid* grid : {&background_, &objects_}) {
    for (const std::span<Corner> best : grid->best) {
      std::fill(best.begin(), best.end(), Corner{});
    }
    std::fill(grid->taken.begin(), grid->taken.end(), std::uint8_t{0});
  }
}

void CornerFinder::occupy(const Eigen::Vector2f& position_px, std::uint8_t body) noexcept {
  Grid& grid = body == kBackgroundLabel ? background_ : objects_;
  grid.taken[grid.index(static_cast<int>(position_px.x()), static_cast<int>(position_px.y()))] =
      static_cast<std::uint8_t>(body + 1);
}

std::span<const Corner> CornerFinder::find(const Plane& image, LabelView labels, const OccupancyMap& occupancy,
                                           Workers* workers) noexcept {
  const float threshold =
      has_objects(labels) ? std::min(background_threshold_, object_threshold_) : background_threshold_;
  const Search search{image, labels, occupancy, threshold};
  in_pieces(workers, kBands, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t band = begin; band < end; ++band) {
      search_band(search, band);
    }
  });
  corners_.clear();
  collect(objects_);
  collect(background_);
  return corners_.span();
}

void CornerFinder::search_band(const Search& search, std::size_t band) noexcept {
  const Plane& image = search.image;
  const Scratch& scratch = scratch_[band];
  const int rows = image.height - 2 * kBorderY;
  const auto begin_of = [&](std::size_t i) { return kBorderY + rows * static_cast<int>(i) / static_cast<int>(kBands); };
  const int first_row = begin_of(band);
  const int end_row = begin_of(band + 1);
  const int first_column = kBorderX;
  const int last_column = image.width - 1 - kBorderX;
  for (const std::span<std::int32_t> sums : {scratch.sums_xx, scratch.sums_xy, scratch.sums_yy}) {
    std::fill(sums.begin(), sums.end(), 0);
  }
  for (int y = first_row - 1 - kWindowRadius; y < first_row - 1 + kWindowRadius; ++y) {
    kernels().corner.accumulate_row(image, y, 1, scratch.sums_xx.data() + kSpill, scratch.sums_xy.data() + kSpill,
                                    scratch.sums_yy.data() + kSpill);
  }
  eigenvalue_row(image, first_row - 1, scratch);
  eigenvalue_row(image, first_row, scratch);
  for (int y = first_row; y < end_row; ++y) {
    eigenvalue_row(image, y + 1, scratch);
    const int count =
        kernels().corner.find_maxima(scratch.eigenvalues(y - 1), scratch.eigenvalues(y), scratch.eigenvalues(y + 1),
                                     first_column, last_column + 1, search.threshold, scratch.columns.data());
    offer_row(search, y, count, band);
  }
}

float* CornerFinder::Scratch::eigenvalues(int y) const noexcept {
  return eigenvalue_rows.data() + static_cast<std::size_t>(y % kRows) * row_stride + kSpill;
}

void CornerFinder::eigenvalue_row(const Plane& image, int y, const Scratch& scratch) noexcept {
  std::int32_t* const xx = scratch.sums_xx.data() + kSpill;
  std::int32_t* const xy = scratch.sums_xy.data() + kSpill;
  std::int32_t* const yy = scratch.sums_yy.data() + kSpill;
  kernels().corner.accumulate_row(image, y + kWindowRadius, 1, xx, xy, yy);
  kernels().corner.eigenvalue_row(xx, xy, yy, 0, image.width, scratch.eigenvalues(y));
  kernels().corner.accumulate_row(image, y - kWindowRadius, -1, xx, xy, yy);
}

void CornerFinder::offer_row(const Search& search, int y, int count, std::size_t band) noexcept {
  const float* const row = scratch_[band].eigenvalues(y);
  for (int i = 0; i < count; ++i) {
    const int x = scratch_[band].columns[static_cast<std::size_t>(i)];
    const std::uint8_t body = search.labels.empty() ? kBackgroundLabel : search.labels.at(x, y);
    if (body == kIgnoreLabel) {
      continue;
    }
    const bool background = body == kBackgroundLabel;
    Grid& grid = background ? background_ : objects_;
    const std::size_t bucket = grid.index(x, y);
    Corner& best = grid.best[band][bucket];
    if (row[x] >= (background ? background_threshold_ : object_threshold_) && row[x] > best.eigenvalue &&
        grid.taken[bucket] != body + 1 && !search.occupancy.near(static_cast<float>(x), static_cast<float>(y))) {
      best = {row[x], static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y), body, row[x - 1] > row[x + 1]};
    }
  }
}

void CornerFinder::collect(const Grid& grid) noexcept {
  const std::size_t before = corners_.size();
  for (std::size_t bucket = 0; bucket < grid.taken.size(); ++bucket) {
    const Corner& upper = grid.best[0][bucket];
    const Corner& lower = grid.best[1][bucket];
    const Corner& best = lower.eigenvalue > upper.eigenvalue ? lower : upper;
    if (best.eigenvalue > 0.F) {
      // Capacity is the number of buckets of both grids.
      static_cast<void>(corners_.push_back(best));
    }
  }
  std::sort(corners_.begin() + before, corners_.end(), stronger);
}

}  // namespace kinetrace::features

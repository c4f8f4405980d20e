#include "kinetrace/segmentation/mask_warp.hpp"

#include <algorithm>
#include <cmath>

#include "kinetrace/core/quantiles.hpp"

namespace kinetrace::segmentation {
namespace {

constexpr std::size_t kMinInside = 3;   ///< Least features in a mask to determine its motion.
constexpr std::size_t kNeighbours = 8;  ///< Features used around a mask with fewer.
constexpr float kAgrees_px = 2.F;       ///< From the median shift...
constexpr float kAgreesPart = 0.1F;     ///< ... plus this part of the mask's size, for a change of scale.
constexpr float kMaxScale = 1.3F;
constexpr float kMinSpread = 0.15F;  ///< Least spread of the features for a scale, as part of the mask's size.
/// Speed of objects relative to what is around them in the image, standard deviation, in their own sizes: people walk
/// at .8 sizes a second, cars drive at 2 to 5, and parallax shifts what is nearer than its surroundings.
constexpr float kSizesPerSecond = 2.5F;
/// Upper bound of this deviation, in sizes: farther away another object is more likely, and the search takes too long.
constexpr float kMaxSizes = 0.5F;

float size_of(const PixelBox& box) noexcept {
  return static_cast<float>(std::max(box.width(), box.height()));
}

GrayView image_of(const RectifiedPair& pair, View view) noexcept {
  return view == View::kLeft ? pair.left : pair.right;
}

}  // namespace

MaskWarp::MaskWarp(const StereoGeometry& geometry, int max_features, bool right, Arena& arena)
    : motions_(arena, static_cast<std::size_t>(max_features)),
      chosen_(arena, static_cast<std::size_t>(max_features)),
      sorted_(arena, static_cast<std::size_t>(max_features)),
      boxes_px_(arena, MaskCanvas::kMaxMasks + 1),
      columns_(arena, static_cast<std::size_t>(geometry.width_px)),
      earlier_(take_image<std::uint16_t>(arena, geometry.width_px, geometry.height_px)),
      has_right_(right),
      match_(arena) {
  for (std::size_t view = 0; view < (right ? 2U : 1U); ++view) {
    images_[view] = {ImagePyramid(geometry.width_px, geometry.height_px, arena),
                     ImagePyramid(geometry.width_px, geometry.height_px, arena)};
  }
}

void MaskWarp::remember(const RectifiedPair& pair) noexcept {
  images_of(View::kLeft).earlier.fill(pair.left);
  if (has_right_) {
    images_of(View::kRight).earlier.fill(pair.right);
  }
  timestamp_ns_ = pair.timestamp_ns;
}

void MaskWarp::collect(std::span<const SeenFeature> seen, std::span<const Feature> now, View view,
                       ImageView<const std::uint16_t> drawn) noexcept {
  motions_.clear();
  for (const Feature& feature : now) {
    const SeenFeature& then = seen[feature.slot];
    if (then.id != feature.id || feature.id == 0) {
      continue;
    }
    Motion motion{0, then.left_px, feature.left_px};
    if (view == View::kRight) {
      motion.then_px.x() = then.u_right_px;
      motion.now_px.x() = feature.u_right_px;
    }
    if (!motion.then_px.allFinite() || !motion.now_px.allFinite()) {
      continue;
    }
    const Eigen::Vector2i pixel = motion.then_px.array().round().cast<int>();
    motion.mask = drawn.contains(pixel.x(), pixel.y()) ? drawn.at(pixel.x(), pixel.y()) : std::uint16_t{0};
    static_cast<void>(motions_.push_back(motion));
  }
}

void MaskWarp::find_boxes(ImageView<const std::uint16_t> drawn, std::size_t masks) noexcept {
  boxes_px_.clear();
  boxes_px_.resize(masks + 1);
  for (int y = 0; y < drawn.height; ++y) {
    const std::uint16_t* row = drawn.row(y);
    for (int x = 0; x < drawn.width; ++x) {
      if (row[x] != 0) {
        boxes_px_[row[x]].include(x, y);
      }
    }
  }
}

Eigen::Vector2f MaskWarp::median_shift(std::span<const Motion> motions) noexcept {
  Eigen::Vector2f shift;
  for (const Eigen::Index axis : {0, 1}) {
    sorted_.clear();
    for (const Motion& motion : motions) {
      static_cast<void>(sorted_.push_back(motion.now_px[axis] - motion.then_px[axis]));
    }
    shift[axis] = median(sorted_);
  }
  return shift;
}

Eigen::Vector2f MaskWarp::shift_around(const PixelBox& box_px) noexcept {
  const Eigen::Vector2f centre(0.5F * static_cast<float>(box_px.x0 + box_px.x1),
                               0.5F * static_cast<float>(box_px.y0 + box_px.y1));
  chosen_.clear();
  for (const Motion& motion : motions_) {
    static_cast<void>(chosen_.push_back(motion));
  }
  const auto distance = [&](const Motion& motion) { return (motion.then_px - centre).squaredNorm(); };
  const std::size_t count = std::min(kNeighbours, chosen_.size());
  std::partial_sort(chosen_.begin(), chosen_.begin() + count, chosen_.end(),
                    [&](const Motion& a, const Motion& b) { return distance(a) < distance(b); });
  chosen_.resize(count);
  return count > 0 ? median_shift(chosen_.span()) : Eigen::Vector2f::Zero();
}

MaskWarp::Similarity MaskWarp::motion_in_images(std::uint16_t mask, View view) noexcept {
  const PixelBox& box_px = boxes_px_[mask];
  const Images& images = images_of(view);
  const float sizes = std::min(kSizesPerSecond * elapsed_s_, kMaxSizes);
  const PredictedShift around{shift_around(box_px), std::max(1.F, sizes * size_of(box_px))};
  return {1.F, match_.shift_px(images.earlier, images.now, earlier_, mask, box_px, around).value_or(around.mean_px)};
}

MaskWarp::Similarity MaskWarp::motion_of(std::uint16_t mask, View view) noexcept {
  const PixelBox& box_px = boxes_px_[mask];
  chosen_.clear();
  for (const Motion& motion : motions_) {
    if (motion.mask == mask) {
      static_cast<void>(chosen_.push_back(motion));
    }
  }
  if (chosen_.size() < kMinInside) {
    return motion_in_images(mask, view);
  }
  const Eigen::Vector2f median = median_shift(chosen_.span());
  const float agrees_px = kAgrees_px + kAgreesPart * size_of(box_px);
  Eigen::Vector2f mean_then = Eigen::Vector2f::Zero();
  Eigen::Vector2f mean_now = Eigen::Vector2f::Zero();
  for (std::size_t i = 0; i < chosen_.size();) {
    if ((chosen_[i].now_px - chosen_[i].then_px - median).norm() > agrees_px) {
      chosen_.swap_remove(i);
      continue;
    }
    mean_then += chosen_[i].then_px;
    mean_now += chosen_[i].now_px;
    ++i;
  }
  if (chosen_.size() < kMinInside) {
    return {1.F, median};
  }
  const auto count = static_cast<float>(chosen_.size());
  mean_then /= count;
  mean_now /= count;
  float both = 0.F;
  float spread = 0.F;
  for (const Motion& motion : chosen_) {
    both += (motion.then_px - mean_then).dot(motion.now_px - mean_now);
    spread += (motion.then_px - mean_then).squaredNorm();
  }
  const bool shows_scale = std::sqrt(spread / count) > kMinSpread * size_of(box_px) && spread > 0.F;
  const float scale = shows_scale ? std::clamp(both / spread, 1.F / kMaxScale, kMaxScale) : 1.F;
  return {scale, mean_now - scale * mean_then};
}

void MaskWarp::move(std::uint16_t mask, const Similarity& motion, ImageView<std::uint16_t> target) noexcept {
  const PixelBox& box = boxes_px_[mask];
  const auto now = [&](int then, Eigen::Index axis) {
    return motion.scale * static_cast<float>(then) + motion.shift_px[axis];
  };
  int x0 = std::max(0, static_cast<int>(std::floor(now(box.x0, 0))));
  const int y0 = std::max(0, static_cast<int>(std::floor(now(box.y0, 1))));
  int x1 = std::min(target.width, static_cast<int>(std::ceil(now(box.x1, 0))) + 1);
  const int y1 = std::min(target.height, static_cast<int>(std::ceil(now(box.y1, 1))) + 1);
  const auto then = [&](int position, Eigen::Index axis) {
    return static_cast<int>(std::lround((static_cast<float>(position) - motion.shift_px[axis]) / motion.scale));
  };
  while (x0 < x1 && then(x0, 0) < 0) {
    ++x0;
  }
  while (x0 < x1 && then(x1 - 1, 0) >= earlier_.width) {
    --x1;
  }
  columns_.clear();
  for (int x = x0; x < x1; ++x) {
    static_cast<void>(columns_.push_back(then(x, 0)));  // as many places as columns
  }
  for (int y = y0; y < y1; ++y) {
    const int from_y = then(y, 1);
    if (from_y < 0 || from_y >= earlier_.height) {
      continue;
    }
    const std::uint16_t* source = earlier_.row(from_y);
    std::uint16_t* row = target.row(y);
    for (int x = x0; x < x1; ++x) {
      if (source[columns_[static_cast<std::size_t>(x - x0)]] == mask && row[x] == 0) {
        row[x] = mask;
      }
    }
  }
}

void MaskWarp::warp(std::span<const SeenFeature> then, const SegmentationInput& now, View view,
                    MaskCanvas& canvas) noexcept {
  const ImageView<std::uint16_t> drawn = canvas.drawn();
  collect(then, now.features, view, drawn);
  images_of(view).now.fill(image_of(now.pair, view));
  elapsed_s_ = static_cast<float>(1e-9 * static_cast<double>(now.pair.timestamp_ns - timestamp_ns_));
  find_boxes(drawn, canvas.mask_count());
  copy_image<std::uint16_t>(drawn, earlier_);
  for (int y = 0; y < drawn.height; ++y) {
    std::fill_n(drawn.row(y), drawn.width, std::uint16_t{kBackgroundLabel});
  }
  for (std::size_t mask = 1; mask < boxes_px_.size(); ++mask) {
    if (!boxes_px_[mask].empty()) {
      move(static_cast<std::uint16_t>(mask), motion_of(static_cast<std::uint16_t>(mask), view), drawn);
    }
  }
}

}  // namespace kinetrace::segmentation

#include "kinetrace/segmentation/region_match.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "dense_kernels.hpp"

namespace kinetrace::segmentation {
namespace {

/// Pixels of a region that are compared; a region with more is matched at a coarser level first.
constexpr int kSamples = 256;
/// Standard deviation of grey differences at the true place, at least: sensor noise, interpolation, limbs that move.
constexpr float kNoise_grey = 4.F;
/// Larger differences are of another surface, in front of the region, and no larger for it.
constexpr int kOccluded_grey = 60;
/// Difference of samples outside the image, as at the true place: what leaves the image is where it was predicted.
constexpr int kUnseen_grey = 15;
/// Independent differences per sample: those of one limb, shadow or reflection go together.
constexpr float kIndependent = 0.05F;
/// Shifts that are tried lie within so many standard deviations of the prediction.
constexpr float kSearchedSigmas = 2.F;
/// Pixels around a coarser level's result that are tried.
constexpr int kRefined_px = 2;

}  // namespace

ImagePyramid::ImagePyramid(int width, int height, Arena& arena) {
  for (MutableGrayView& level : levels_) {
    level = take_image<std::uint8_t>(arena, width, height + 1);  // vectors reach beyond the last row
    level.height = height;
    width /= 2;
    height /= 2;
  }
}

void ImagePyramid::fill(GrayView image) noexcept {
  filled_ = !image.empty();
  if (!filled_) {
    return;
  }
  copy_image<std::uint8_t>(image, levels_[0]);
  for (std::size_t level = 1; level < levels_.size(); ++level) {
    dense_kernels().decimate(levels_[level - 1], 2, levels_[level]);
  }
}

RegionMatch::RegionMatch(Arena& arena) : samples_(arena, kSamples) {}

void RegionMatch::take_samples(GrayView earlier, int level, ImageView<const std::uint16_t> drawn, std::uint16_t label,
                               const PixelBox& box_px) noexcept {
  samples_.clear();
  const PixelBox box{box_px.x0 >> level, box_px.y0 >> level, std::min(earlier.width, (box_px.x1 >> level) + 1),
                     std::min(earlier.height, (box_px.y1 >> level) + 1)};
  const int middle = (1 << level) / 2;
  // A grid over the box that holds no more than kSamples.
  const float pixels = static_cast<float>(box.width()) * static_cast<float>(box.height());
  const int step = std::max(1, static_cast<int>(std::ceil(std::sqrt(pixels / kSamples))));
  for (int y = box.y0 + step / 2; y < box.y1; y += step) {
    const std::uint16_t* labels = drawn.row(std::min(drawn.height - 1, (y << level) + middle));
    for (int x = box.x0 + step / 2; x < box.x1; x += step) {
      if (labels[std::min(drawn.width - 1, (x << level) + middle)] == label) {
        static_cast<void>(samples_.push_back(
            {static_cast<std::int16_t>(x), static_cast<std::int16_t>(y), static_cast<std::int16_t>(earlier.at(x, y))}));
      }
    }
  }
}

// Of normal differences with unknown variance. Brightness counts: exposure hardly changes between frames.
float RegionMatch::log_likelihood(GrayView now, int shift_x, int shift_y) const noexcept {
  int squares = 0;
  for (const Sample& sample : samples_) {
    const int x = sample.x + shift_x;
    const int y = sample.y + shift_y;
    if (now.contains(x, y)) {
      const int difference = std::min(kOccluded_grey, std::abs(now.row(y)[x] - sample.grey));
      squares += difference * difference;
    } else {
      squares += kUnseen_grey * kUnseen_grey;
    }
  }
  const auto count = static_cast<float>(samples_.size());
  const float variance = static_cast<float>(squares) / std::max(count, 1.F);
  return -0.5F * kIndependent * count * std::log(variance + kNoise_grey * kNoise_grey);
}

std::optional<Eigen::Vector2f> RegionMatch::shift_px(const ImagePyramid& earlier, const ImagePyramid& now,
                                                     ImageView<const std::uint16_t> drawn, std::uint16_t label,
                                                     const PixelBox& box_px, const PredictedShift& predicted) noexcept {
  if (earlier.empty() || now.empty()) {
    return std::nullopt;
  }
  int level = 0;
  while (level + 1 < ImagePyramid::kLevels && (box_px.width() >> level) * (box_px.height() >> level) > kSamples) {
    ++level;
  }
  Eigen::Vector2i best = (predicted.mean_px / static_cast<float>(1 << level)).array().round().cast<int>();
  int reach = std::max(kRefined_px, static_cast<int>(std::ceil(kSearchedSigmas * predicted.sigma_px)) >> level);
  for (; level >= 0; --level) {
    take_samples(earlier.level(level), level, drawn, label, box_px);
    const auto scale = static_cast<float>(1 << level);
    const Eigen::Vector2i middle = best;
    float highest = -std::numeric_limits<float>::infinity();
    for (int y = middle.y() - reach; y <= middle.y() + reach; ++y) {
      for (int x = middle.x() - reach; x <= middle.x() + reach; ++x) {
        const Eigen::Vector2f error_px = scale * Eigen::Vector2f(x, y) - predicted.mean_px;
        const float probability = log_likelihood(now.level(level), x, y) -
                                  0.5F * error_px.squaredNorm() / (predicted.sigma_px * predicted.sigma_px);
        if (probability > highest) {
          highest = probability;
          best = {x, y};
        }
      }
    }
    if (level > 0) {
      best *= 2;
      reach = kRefined_px;
    }
  }
  return best.cast<float>();
}

}  // namespace kinetrace::segmentation

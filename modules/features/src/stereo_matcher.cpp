#include "stereo_matcher.hpp"

#include <algorithm>
#include <cmath>

#include "kernels.hpp"
#include "patch_gate.hpp"

namespace kinetrace::features {
namespace {

constexpr int kLargestDisparity = 256;
// Below zero nothing is there, but a minimum at zero needs a neighbour on its other side.
constexpr int kSmallestDisparity = -2;
constexpr int kMaxCosts = kLargestDisparity - 2 * kSmallestDisparity + 1;
// Costs this near the best one belong to the same minimum.
constexpr int kMinimumHalfWidth = 3;
// Around an expected disparity: a fixed and a relative part.
constexpr float kNarrow_px = 4.F;
constexpr float kNarrowRatio = 0.08F;
// Rows to try when the feature's own gives nothing: the patch tolerates about one row on either side.
constexpr std::array<int, 3> kRowOffsets{0, -2, 2};

// Rectification is good to about half a pixel; texture that knows better overrules this.
constexpr float kNoise_gray = 2.5F;
constexpr float kRowSigma_px = 0.5F;
constexpr float kSlantSigma = 0.1F;
constexpr WarpOptions kSlantOptions{.prior_weight = kNoise_gray * kNoise_gray / (kSlantSigma * kSlantSigma),
                                    .horizontal_only = true};
constexpr int kPassesKnown = 1;
constexpr int kPassesNew = 3;
// A surface seen more obliquely than this looks too different in the two images.
constexpr float kLeastWidthRatio = 0.5F;
constexpr float kMostWidthRatio = 2.F;
constexpr float kMostShear = 1.F;

using Costs = std::array<std::uint16_t, kMaxCosts>;

int index_of_least(const Costs& costs, int count) noexcept {
  return static_cast<int>(std::min_element(costs.begin(), costs.begin() + count) - costs.begin());
}

/// True if no other minimum comes near the best one: repetitive texture has many.
bool stands_out(const Costs& costs, int count, int best, float ratio) noexcept {
  const float limit = static_cast<float>(costs[static_cast<std::size_t>(best)]) * ratio;
  for (int i = 0; i < count; ++i) {
    if (std::abs(i - best) > kMinimumHalfWidth && static_cast<float>(costs[static_cast<std::size_t>(i)]) < limit) {
      return false;
    }
  }
  return true;
}

}  // namespace

bool StereoMatcher::match(const StereoImages& images, float expected_disparity_px, FeatureSlot& slot) const noexcept {
  Feature& feature = slot.feature;
  feature.u_right_px = kNoRight;
  feature.v_px = feature.left_px.y();
  const int x = static_cast<int>(std::floor(feature.left_px.x()));
  int disparity = 0;
  if (expected_disparity_px >= 0.F) {
    const float reach = kNarrow_px + kNarrowRatio * expected_disparity_px;
    const Range near = clipped(expected_disparity_px - reach, expected_disparity_px + reach, x);
    if (search(images, feature, near, 0, false, disparity) &&
        refine(images, static_cast<float>(disparity), 0.F, kPassesKnown, slot)) {
      return true;
    }
  }
  const Range all = clipped(static_cast<float>(kSmallestDisparity), static_cast<float>(config_.max_disparity_px), x);
  slot.to_right = kNoWarp;
  for (const int row_offset : kRowOffsets) {
    if (std::abs(static_cast<float>(row_offset)) <= config_.max_row_difference_px &&
        search(images, feature, all, row_offset, true, disparity) &&
        refine(images, static_cast<float>(disparity), static_cast<float>(row_offset), kPassesNew, slot)) {
      return true;
    }
  }
  return false;
}

StereoMatcher::Range StereoMatcher::clipped(float from, float to, int x) const noexcept {
  const int first = std::max(static_cast<int>(std::floor(from)), kSmallestDisparity);
  // The right patch stays in the image.
  const int last =
      std::min({static_cast<int>(std::ceil(to)), config_.max_disparity_px - kSmallestDisparity, x - kPatchWidth / 2});
  return {first, std::max(0, last - first + 1)};
}

bool StereoMatcher::search(const StereoImages& images, const Feature& feature, Range range, int row_offset, bool unique,
                           int& disparity) const noexcept {
  constexpr int kLeastCosts = 3;
  if (range.count < kLeastCosts) {
    return false;
  }
  const int x = static_cast<int>(std::floor(feature.left_px.x()));
  const int y = static_cast<int>(std::lround(feature.left_px.y()));
  const int right_y = std::clamp(y + row_offset, 0, images.right.height - 1);
  Costs costs;
  kernels().search.row_costs(images.left_gradient, x, y, images.right_gradient, right_y, -1, range.first, range.count,
                             costs.data());
  const int best = index_of_least(costs, range.count);
  // A minimum at the end of the range is the slope of one outside.
  if (best == 0 || best == range.count - 1 ||
      (unique && !stands_out(costs, range.count, best, config_.uniqueness_ratio))) {
    return false;
  }
  disparity = range.first + best;

  const int right_x = x - disparity;
  const int last = std::min(range.first + range.count - 1, images.left.width - 1 - kPatchWidth / 2 - right_x);
  const int count = last - range.first + 1;
  if (count < 1) {
    return false;
  }
  kernels().search.row_costs(images.right_gradient, right_x, right_y, images.left_gradient, y, 1, range.first, count,
                             costs.data());
  return std::abs(range.first + index_of_least(costs, count) - disparity) <= 1;
}

bool StereoMatcher::refine(const StereoImages& images, float disparity, float row_offset, int passes,
                           FeatureSlot& slot) const noexcept {
  Feature& feature = slot.feature;
  const AlignOptions options{.max_iterations = 8,
                             .converged_px = 0.01F,
                             .max_shift_px = 4.F,
                             .preferred_row = feature.left_px.y(),
                             .row_weight = kNoise_gray * kNoise_gray / (kRowSigma_px * kRowSigma_px)};
  PatchWarp warp = slot.to_right;
  Eigen::Vector2f right(feature.left_px.x() - disparity, feature.left_px.y() + row_offset);
  PatchFit fit{};
  for (int pass = 0; pass < passes; ++pass) {
    PatchTemplate patch;
    if (!kernels().patch.sample_warped(images.left, feature.left_px.x(), feature.left_px.y(), warp, &patch) ||
        !kernels().patch.align(images.right, patch, options, &right.x(), &right.y()) ||
        !patch_inside(images.right, right)) {
      return false;
    }
    fit = kernels().patch.refine_warp(images.right, patch, right.x(), right.y(), kSlantOptions, &warp);
  }
  const float refined_disparity = feature.left_px.x() - right.x();
  if (!looks_alike(fit, config_) || refined_disparity < config_.min_disparity_px ||
      refined_disparity > static_cast<float>(config_.max_disparity_px) ||
      std::abs(right.y() - feature.left_px.y()) > config_.max_row_difference_px) {
    return false;
  }
  const bool plausible = warp.xx > kLeastWidthRatio && warp.xx < kMostWidthRatio && std::abs(warp.xy) < kMostShear;
  slot.to_right = plausible ? warp : kNoWarp;
  feature.u_right_px = right.x();
  feature.v_px = 0.5F * (feature.left_px.y() + right.y());
  return true;
}

}  // namespace kinetrace::features

// Alignment of a partly masked patch, on images whose masked-out part moves differently.
#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <vector>

#include <gtest/gtest.h>

#include "feature_slot.hpp"
#include "front_end_harness.hpp"
#include "kernels.hpp"
#include "picture.hpp"

namespace kinetrace::features {
namespace {

using Eigen::Vector2d;
using Eigen::Vector2f;
using testing::kExactly;
using testing::median;
using testing::Picture;
using testing::surface;
using testing::Texture;

constexpr double kContour = 9.0;        // Own columns to the right of a patch's first one.
constexpr std::uint16_t kOwn = 0x00FF;  // Those, but the last.

PatchMask own_columns() {
  PatchMask mask{{}, false};
  std::fill(std::begin(mask.rows), std::end(mask.rows), kOwn);
  return mask;
}

/// Position in `to` of the patch at `at` in `from`, searched from `start`; far away if not found.
Vector2f found(const Picture& from, const Picture& to, const Vector2f& at, const PatchMask& mask,
               const Vector2f& start) {
  PatchTemplate patch;
  kernels().patch_template.sample(from.plane(), at.x(), at.y(), mask, &patch);
  Vector2f position = start;
  const bool aligned = kernels().patch.align(to.plane(), patch, kExactly, &position.x(), &position.y());
  return aligned ? position : Vector2f(-1e3F, -1e3F);
}

struct Errors {
  std::vector<double> masked_px;
  std::vector<double> whole_px;
};

/// Patches across a contour: their own part moves by `shift`, the part beyond changes between the views.
Errors align_across_contours(const Vector2d& shift, const testing::PixelValue& beyond_before,
                             const testing::PixelValue& beyond_after, double gain = 1.0, double offset_gray = 0.0) {
  const Texture own(31);
  Errors errors;
  for (int i = 0; i < 9; ++i) {
    const Vector2f at(40.5F + 17.F * static_cast<float>(i), 38.F + static_cast<float>(i % 3));
    const double contour = double{at.x()} - double{kPatchHalfWidth} + kContour - 0.5;
    const Picture before(surface(own, contour, Vector2d::Zero(), beyond_before), 1.0, 1);
    const auto moved = surface(own, contour, shift, beyond_after);
    const Picture after([&](const Vector2d& p) { return gain * moved(p) + offset_gray; }, 1.0, 2);
    const Vector2f truth = at + shift.cast<float>();
    const Vector2f start = truth + Vector2f(0.8F, -0.6F);
    errors.masked_px.push_back(double{(found(before, after, at, own_columns(), start) - truth).norm()});
    errors.whole_px.push_back(double{(found(before, after, at, kWholePatch, start) - truth).norm()});
  }
  return errors;
}

void expect_found_under_the_mask_alone(const Errors& errors) {
  EXPECT_LT(median(errors.masked_px), 0.05);
  EXPECT_LT(*std::max_element(errors.masked_px.begin(), errors.masked_px.end()), 0.15);
  EXPECT_GT(median(errors.whole_px), 0.3);
}

TEST(MaskedPatch, IsFoundWhereItsOwnPartHasMovedThoughTheRestWentElsewhere) {
  const Texture beyond(32);
  expect_found_under_the_mask_alone(align_across_contours(
      {2.3, -1.4}, std::cref(beyond), [&](const Vector2d& p) { return beyond(p - Vector2d(0.4, -0.2)); }));
}

TEST(MaskedPatch, IsFoundBesideSomethingNeverSeenBefore) {
  const Texture before(33, 50.0);
  const Texture after(34, 50.0);
  expect_found_under_the_mask_alone(align_across_contours({-1.7, 0.6}, std::cref(before), std::cref(after)));
}

TEST(MaskedPatch, IsFoundUnderGainAndOffset) {
  const Texture beyond(32);
  const auto moved = [&](const Vector2d& p) { return beyond(p - Vector2d(0.4, -0.2)); };
  expect_found_under_the_mask_alone(align_across_contours({2.3, -1.4}, std::cref(beyond), moved, 0.7, 30.0));
}

TEST(MaskedPatch, LooksLikeItselfWhateverIsBesideItAndHoweverBright) {
  const Texture own(31);
  const Texture other(35, 60.0);
  const Vector2f at(100.5F, 40.F);
  const double contour = double{at.x()} - double{kPatchHalfWidth} + kContour - 0.5;
  const Picture plain(surface(own, contour, Vector2d::Zero(), [](const Vector2d&) { return 128.0; }));
  const auto elsewhere = surface(own, contour, Vector2d::Zero(), std::cref(other));
  const Picture darker([&](const Vector2d& p) { return 0.6 * elsewhere(p) + 20.0; });
  PatchTemplate patch;
  kernels().patch_template.sample(plain.plane(), at.x(), at.y(), own_columns(), &patch);
  EXPECT_NEAR(kernels().patch.fit(plain.plane(), patch, at.x(), at.y()).correlation, 1.F, 1e-4F);
  EXPECT_NEAR(kernels().patch.fit(plain.plane(), patch, at.x(), at.y()).residual_rms, 0.F, 0.05F);
  const PatchFit fit = kernels().patch.fit(darker.plane(), patch, at.x(), at.y());
  EXPECT_GT(fit.correlation, 0.999F);
  EXPECT_LT(fit.residual_rms, 0.6F) << "rounding to whole gray values";
  kernels().patch_template.sample(plain.plane(), at.x(), at.y(), kWholePatch, &patch);
  EXPECT_LT(kernels().patch.fit(darker.plane(), patch, at.x(), at.y()).correlation, 0.9F);
}

}  // namespace
}  // namespace kinetrace::features

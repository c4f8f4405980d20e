// The last step of an alignment: the centre of a patch determines its position.
#include "centre_alignment.hpp"

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

struct Found {
  Vector2f whole{0.F, 0.F};   ///< Aligned by the whole patch.
  Vector2f centre{0.F, 0.F};  ///< Then by its centre.
};

Found find(const Picture& from, const Picture& to, const Vector2f& at, const PatchMask& mask, const Vector2f& start) {
  PatchTemplate patch;
  kernels().patch_template.sample(from.plane(), at.x(), at.y(), mask, &patch);
  Found found{start, start};
  EXPECT_TRUE(kernels().patch.align(to.plane(), patch, kExactly, &found.whole.x(), &found.whole.y()));
  found.centre = found.whole;
  align_centre(to.plane(), kExactly, patch, found.centre);
  return found;
}

/// Signed errors along the rows of patches in two views, aligned from .8 and .6 px off.
struct Errors {
  std::vector<double> whole_px;
  std::vector<double> centre_px;
};

/// The centre of each patch and `own_columns` columns to its right move by `shift`, the rest by `shift_beyond`.
/// Contours are not anti-aliased, so they move by whole columns.
Errors across_contours(double own_columns, const Vector2d& shift, const Vector2d& shift_beyond, double gain = 1.0,
                       double offset_gray = 0.0) {
  const Texture own(51);
  const Texture beyond(52);
  Errors errors;
  for (int i = 0; i < 33; ++i) {
    const Vector2f at(30.5F + 5.3F * static_cast<float>(i), 38.F + static_cast<float>(i % 3));
    const double contour = double{at.x()} + own_columns;
    const Picture before(surface(own, contour, Vector2d::Zero(), std::cref(beyond)), 1.0, 2 * static_cast<unsigned>(i));
    const auto moved = surface(own, contour, shift, [&](const Vector2d& p) { return beyond(p - shift_beyond); });
    const Picture after([&](const Vector2d& p) { return gain * moved(p) + offset_gray; }, 1.0,
                        2 * static_cast<unsigned>(i) + 1);
    const Vector2f truth = at + shift.cast<float>();
    const Found found = find(before, after, at, kWholePatch, truth + Vector2f(0.8F, -0.6F));
    errors.whole_px.push_back(double{found.whole.x() - truth.x()});
    errors.centre_px.push_back(double{found.centre.x() - truth.x()});
  }
  return errors;
}

TEST(CentreAlignment, IsDrawnFarLessToWhatLiesBeyondAContour) {
  for (const double beyond_px : {-1.0, -0.6, 0.6, 1.0}) {
    const Errors errors = across_contours(3.5, {2.0, 0.3}, {2.0 + beyond_px, 0.3});
    const double whole = median(errors.whole_px) / beyond_px;
    const double centre = median(errors.centre_px) / beyond_px;
    EXPECT_GT(whole, 0.06) << "or there is nothing to mend";
    EXPECT_LT(centre, 0.5 * whole);
  }
}

TEST(CentreAlignment, IsUnbiasedOnOneSurface) {
  const Errors errors = across_contours(20.0, {1.7, -0.4}, {0.0, 0.0});
  std::vector<double> sizes;
  std::transform(errors.centre_px.begin(), errors.centre_px.end(), std::back_inserter(sizes),
                 [](double error) { return std::abs(error); });
  EXPECT_NEAR(median(errors.centre_px), 0.0, 0.01);
  EXPECT_LT(median(sizes), 0.03);
}

TEST(CentreAlignment, IsBlindToGainAndOffset) {
  const Errors plain = across_contours(3.5, {2.0, 0.3}, {1.4, 0.3});
  const Errors darker = across_contours(3.5, {2.0, 0.3}, {1.4, 0.3}, 0.6, 40.0);
  EXPECT_NEAR(median(darker.centre_px), median(plain.centre_px), 0.02);
}

TEST(CentreAlignment, LeavesOutWhatTheMaskLeavesOut) {
  const Texture own(51);
  const Texture before(53, 60.0);
  const Texture after(54, 60.0);
  PatchMask mask{{}, false};
  std::fill(std::begin(mask.rows), std::end(mask.rows), std::uint16_t{0x01FF});  // All to the left of the contour.
  std::vector<double> errors;
  for (int i = 0; i < 17; ++i) {
    const Vector2f at(40.5F + 9.F * static_cast<float>(i), 38.F);
    const double contour = double{at.x()} + 2.0;
    const Picture first(surface(own, contour, Vector2d::Zero(), std::cref(before)));
    const Picture second(surface(own, contour, {2.0, 0.2}, std::cref(after)));
    const Vector2f truth = at + Vector2f(2.F, 0.2F);
    errors.push_back(double{(find(first, second, at, mask, truth + Vector2f(0.5F, 0.5F)).centre - truth).norm()});
  }
  EXPECT_LT(median(errors), 0.05);
}

TEST(CentreAlignment, LeavesThePositionWhereTheMiddleHoldsNothing) {
  const Texture texture(51);
  const Picture picture(std::cref(texture));
  PatchMask rim{{}, false};
  std::fill(std::begin(rim.rows), std::end(rim.rows), std::uint16_t{0x0001});
  PatchTemplate patch;
  kernels().patch_template.sample(picture.plane(), 100.5F, 40.F, rim, &patch);
  Vector2f position(100.9F, 40.2F);
  align_centre(picture.plane(), kExactly, patch, position);
  EXPECT_EQ(position, Vector2f(100.9F, 40.2F));
}

TEST(CentreAlignment, DoesNotGoToAnotherPlace) {
  const Texture texture(51);
  const Picture picture(std::cref(texture));
  PatchTemplate patch;
  kernels().patch_template.sample(picture.plane(), 100.5F, 40.F, kWholePatch, &patch);
  // Beyond the largest correction.
  Vector2f position(103.F, 40.F);
  align_centre(picture.plane(), kExactly, patch, position);
  EXPECT_EQ(position, Vector2f(103.F, 40.F));
}

}  // namespace
}  // namespace kinetrace::features

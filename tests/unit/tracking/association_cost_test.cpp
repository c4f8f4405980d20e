#include "association_cost.hpp"

#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

namespace kinetrace::tracking {
namespace {

constexpr int kImageWidth = 640;
constexpr int kImageHeight = 240;

BoxPrediction predicted_at(const PixelBox& box, double position_sigma_px = 4.0, double size_sigma = 0.05) {
  return {.low_px = {box.x0, box.y0},
          .high_px = {box.x1, box.y1},
          .position_sigma_px = {position_sigma_px, position_sigma_px},
          .size_sigma = size_sigma};
}

PixelBox moved(PixelBox box, int dx, int dy = 0) {
  return {box.x0 + dx, box.y0 + dy, box.x1 + dx, box.y1 + dy};
}

constexpr PixelBox kCar{300, 80, 360, 120};

TEST(BoxEvidence, FallsWithTheSquaredInnovationInSigmas) {
  const BoxPrediction predicted = predicted_at(kCar, 4.0, 0.0);
  const double at_predicted_position = box_evidence(predicted, kCar, kImageWidth, kImageHeight);
  EXPECT_GT(at_predicted_position, 5.0);
  // Both edges of the axis share the position error, and each has 1.5 px and 4 % of 60 px: their mean has half that
  // variance.
  const double variance_px2 = 4.0 * 4.0 + 0.5 * (1.5 * 1.5 + 2.4 * 2.4);
  for (const int dx : {3, -3, 5}) {
    const double expected = at_predicted_position - 0.5 * dx * dx / variance_px2;
    EXPECT_NEAR(box_evidence(predicted, moved(kCar, dx), kImageWidth, kImageHeight), expected, 1e-9) << dx;
  }
  EXPECT_LT(box_evidence(predicted, moved(kCar, 40), kImageWidth, kImageHeight), 0.0);
}

TEST(BoxEvidence, LessIsKnownOfThePlaceTheLessItSays) {
  const double sure = box_evidence(predicted_at(kCar, 2.0), kCar, kImageWidth, kImageHeight);
  const double uncertain = box_evidence(predicted_at(kCar, 20.0), kCar, kImageWidth, kImageHeight);
  EXPECT_GT(sure, uncertain);
  const PixelBox beside = moved(kCar, 20);
  EXPECT_LT(box_evidence(predicted_at(kCar, 2.0), beside, kImageWidth, kImageHeight),
            box_evidence(predicted_at(kCar, 20.0), beside, kImageWidth, kImageHeight));
}

TEST(BoxEvidence, AnotherSizeIsAnotherObjectUnlessItsSizeIsNotKnown) {
  const PixelBox twice{270, 60, 390, 140};
  EXPECT_LT(box_evidence(predicted_at(kCar), twice, kImageWidth, kImageHeight), 0.0);
  EXPECT_GT(box_evidence(predicted_at(kCar, 4.0, 0.6), twice, kImageWidth, kImageHeight), 0.0);
}

TEST(BoxEvidence, OfAHiddenObjectAnyPartMayBeSeenAndNothingBesideIt) {
  BoxPrediction predicted = predicted_at(kCar);
  const PixelBox part{345, 90, 355, 110};
  const double in_view = box_evidence(predicted, part, kImageWidth, kImageHeight);
  predicted.occluded = 0.8;
  EXPECT_GT(box_evidence(predicted, part, kImageWidth, kImageHeight), in_view);
  EXPECT_GT(box_evidence(predicted, part, kImageWidth, kImageHeight), 0.0);
  EXPECT_LT(box_evidence(predicted, moved(part, 60), kImageWidth, kImageHeight), 0.0);
}

TEST(BoxEvidence, AnEdgeThatIsUncertainMayBeOccludedAsWell) {
  BoxPrediction predicted = predicted_at(kCar, 4.0, 0.05);
  predicted.low_sigma_px.setConstant(12.0);
  predicted.high_sigma_px.setConstant(12.0);
  predicted.occluded = 0.5;
  const auto roof = [&](int height_px) {
    return box_evidence(predicted, {kCar.x0, kCar.y0, kCar.x1, kCar.y0 + height_px}, kImageWidth, kImageHeight);
  };
  // Lower edges at 1.7 and 2.4 sigmas inside: where the occluder ends says nothing about this object, but new objects
  // of either size are not equally likely.
  EXPECT_NEAR(roof(18) - roof(10), std::log(1.8), 1e-9);
  EXPECT_GT(roof(18), 0.0);
}

TEST(BoxEvidence, TheBordersOfTheImageHideWhatIsBeyond) {
  const PixelBox leaving{-40, 80, 20, 120};
  const PixelBox seen{0, 80, 20, 120};
  EXPECT_GT(box_evidence(predicted_at(leaving), seen, kImageWidth, kImageHeight), 5.0);
  EXPECT_LT(box_evidence(predicted_at(leaving), moved(seen, 4), kImageWidth, kImageHeight),
            box_evidence(predicted_at(leaving), seen, kImageWidth, kImageHeight))
      << "what is inside the image is all there is of it";
}

TEST(BoxEvidence, AnObjectThatTheBorderHadCutOffMayReachFartherThanItsMask) {
  // Predicted from a mask that was cut off on the left: it has moved in, and more of the object with it.
  BoxPrediction predicted = predicted_at({40, 80, 100, 120});
  const PixelBox whole{0, 80, 100, 120};
  EXPECT_LT(box_evidence(predicted, whole, kImageWidth, kImageHeight), 0.0);
  predicted.low_is_cut = {true, false};
  EXPECT_GT(box_evidence(predicted, whole, kImageWidth, kImageHeight), 5.0);
  // It reaches at least as far as the mask, and the other sides are measured.
  EXPECT_LT(box_evidence(predicted, {80, 80, 100, 120}, kImageWidth, kImageHeight),
            box_evidence(predicted, whole, kImageWidth, kImageHeight));
  EXPECT_LT(box_evidence(predicted, {0, 80, 140, 120}, kImageWidth, kImageHeight), 0.0);
}

TEST(FeatureEvidence, CountsManyFeaturesAsAFew) {
  EXPECT_EQ(feature_evidence(0, 0), 0.0);
  EXPECT_GT(feature_evidence(1, 1), 0.0);
  EXPECT_LT(feature_evidence(0, 1), 0.0);
  EXPECT_GT(feature_evidence(20, 20), feature_evidence(2, 2));
  EXPECT_LT(feature_evidence(1000, 1000), 1.2 * feature_evidence(50, 50));
  EXPECT_LT(feature_evidence(2, 20), 0.0);
}

TEST(DisparityEvidence, SpeaksAgainstAnotherDepthAndIsSilentWithoutOne) {
  EXPECT_EQ(disparity_evidence(0.0, 0.0, 10.0, 5), 0.0);
  EXPECT_EQ(disparity_evidence(10.0, 0.0, 0.0, 0), 0.0);
  EXPECT_GT(disparity_evidence(10.0, 0.0, 10.0, 5), 0.0);
  EXPECT_LT(disparity_evidence(10.0, 0.0, 14.0, 5), -5.0);
  EXPECT_GT(disparity_evidence(10.0, 3.0, 14.0, 5), 0.0) << "where it is now is not known so well";
  EXPECT_NEAR(disparity_evidence(10.0, 0.0, 9.0, 5), disparity_evidence(10.0, 0.0, 11.0, 5), 1e-12);
}

TEST(DisparityEvidence, OfFewFeaturesAllMayLieOnSomethingElse) {
  EXPECT_GT(disparity_evidence(10.0, 0.0, 40.0, 1), -2.0);
  EXPECT_GT(disparity_evidence(10.0, 0.0, 40.0, 1), disparity_evidence(10.0, 0.0, 40.0, 3));
  EXPECT_EQ(disparity_evidence(10.0, 0.0, 40.0, 50), disparity_evidence(10.0, 0.0, 80.0, 60)) << "and never says all";
}

// Metres as pixels: x, y, disparity.
TEST(VolumeEvidence, IsForPointsInsideAndAgainstPointsOutside) {
  const PredictedVolume volume{.half_size_m = {10.0, 5.0, 2.0}, .sigma_m = {0.5, 0.5, 0.5}};
  const auto evidence_at = [&](const PredictedVolume& in, float x, float disparity_px) {
    const std::vector<DisparitySample> samples(4, DisparitySample{{x, 0.F}, disparity_px});
    return volume_evidence(in, samples);
  };
  EXPECT_GT(evidence_at(volume, 0.F, 0.5F), 3.0);
  EXPECT_GT(evidence_at(volume, 10.F, 0.5F), 3.0) << "visible surfaces lie on faces";
  EXPECT_LT(evidence_at(volume, 14.F, 0.5F), 0.0);
  EXPECT_LT(evidence_at(volume, 0.F, 6.F), 0.0);
  PredictedVolume uncertain = volume;
  uncertain.sigma_m.setConstant(5.0);
  EXPECT_GT(evidence_at(uncertain, 14.F, 0.5F), evidence_at(volume, 14.F, 0.5F));
  EXPECT_LT(evidence_at(uncertain, 0.F, 0.5F), evidence_at(volume, 0.F, 0.5F)) << "it may be elsewhere";
  uncertain.sigma_m.setConstant(100.0);
  EXPECT_LT(evidence_at(uncertain, 0.F, 0.5F), 0.0) << "a volume that may be anywhere holds nothing";
  EXPECT_EQ(volume_evidence(volume, {}), 0.0);
}

TEST(ExtentEvidence, SpeaksAgainstACentreOutsideByItsDistanceInStandardDeviations) {
  const ImageExtent extent{
      .low_px = {100.0, 50.0}, .high_px = {200.0, 90.0}, .low_sigma_px = {20.0, 20.0}, .high_sigma_px = {40.0, 40.0}};
  EXPECT_EQ(extent_evidence(extent, {150, 60, 260, 80}), -0.5 * std::pow(5.0 / std::hypot(40.0, 1.5), 2)) << "205 px";
  EXPECT_EQ(extent_evidence(extent, {140, 60, 260, 80}), 0.0);
  EXPECT_NEAR(extent_evidence(extent, {40, 60, 80, 80}), -2.0, 0.02) << "two standard deviations";
  EXPECT_NEAR(extent_evidence(extent, {40, 0, 80, 20}), -4.0, 0.04);
  EXPECT_LT(extent_evidence({.low_px = {100.0, 50.0}, .high_px = {200.0, 90.0}}, {300, 60, 320, 80}), -1000.0);
}

TEST(DetectionEvidence, AMissSpeaksAgainstWhatIsInPlainSightOnly) {
  EXPECT_GT(detection_evidence(1.0), 2.0);
  EXPECT_LT(detection_evidence(0.0), 0.0);
  EXPECT_EQ(detection_evidence(-1.0), detection_evidence(0.0));
}

TEST(FragmentEvidence, IsNoneAwayFromOtherObjects) {
  EXPECT_EQ(fragment_evidence(0.0), 0.0);
  EXPECT_GT(fragment_evidence(0.8), fragment_evidence(0.2));
}

}  // namespace
}  // namespace kinetrace::tracking

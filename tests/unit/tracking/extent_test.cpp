// Association by the extent of an object's box, which its mask shows only in part.
#include <array>
#include <optional>

#include "mask_scene.hpp"

namespace kinetrace::tracking {
namespace {

Shape rectangle(int x0, int y0, int x1, int y1) {
  return {.x = 0.5 * (x0 + x1 - 1),
          .y = 0.5 * (y0 + y1 - 1),
          .half_width = 0.5 * (x1 - x0 - 1),
          .half_height = 0.5 * (y1 - y0 - 1)};
}

constexpr double kSigma_px = 6.0;

/// Id of the track that is assigned the second of two consecutive detections, without features.
std::uint32_t id_after(const Shape& before, const Shape& after, const std::optional<ImageExtent>& expected) {
  TrackerScene scene({}, 0);
  for (int i = 0; i < 4; ++i) {
    scene.step(std::array{before});
  }
  ObjectPrediction prediction{.known = true, .point_px = {before.x, before.y}, .depth_m = 10.0};
  prediction.extent = expected;
  scene.object_predictions.assign(1, prediction);
  scene.step(std::array{after});
  return scene.track_of(0)->id;
}

TEST(Extent, KeepsTheTrackOfWhatAnUnknownOccluderReveals) {
  const Shape rear = rectangle(280, 90, 320, 130);
  const Shape whole = rectangle(280, 90, 380, 130);
  EXPECT_EQ(id_after(rear, whole, extent_of(whole, kSigma_px)), 1U);
  EXPECT_EQ(id_after(rear, whole, extent_of(rear, kSigma_px)), 2U);
  EXPECT_EQ(id_after(rear, whole, {}), 2U) << "by its mask, the object ends at 320 px";
}

TEST(Extent, AnObjectThatHasLeftTheImageTakesNothingAtItsBorder) {
  const Shape leaving = rectangle(0, 36, 96, 225);
  const Shape entering = rectangle(0, 222, 116, 240);
  EXPECT_EQ(id_after(leaving, entering, extent_of(rectangle(-900, 36, -10, 225), kSigma_px)), 2U);
  EXPECT_EQ(id_after(leaving, entering, extent_of(rectangle(-900, 215, 120, 300), kSigma_px)), 1U);
}

/// Stereo measurements in these columns, at any row, with disparities about 10 px.
PredictedVolume columns(double x0, double x1) {
  PredictedVolume volume{.half_size_m = {0.5 * (x1 - x0), 500.0, 2.0}, .sigma_m = {1.0, 1.0, 0.1}};
  volume.T_box_stereo.topRightCorner<3, 1>() << -0.5 * (x0 + x1), 0.0, -10.0;
  return volume;
}

/// Id of the track that is assigned a new detection where no mask is predicted, with features that were on no track.
/// The object's own features are lost.
std::uint32_t id_of_part(const std::optional<PredictedVolume>& volume, const ImageExtent& extent, int features = 12) {
  const Shape front = rectangle(100, 60, 300, 200);
  const Shape door = rectangle(330, 90, 370, 130);
  TrackerScene scene({}, features);
  scene.detected = {true, false};
  for (int i = 0; i < 4; ++i) {
    scene.step(std::array{front, door});
  }
  ObjectPrediction prediction{.known = true, .point_px = {front.x, front.y}, .depth_m = 10.0};
  prediction.extent = extent;
  prediction.volume = volume;
  scene.object_predictions.assign(1, prediction);
  scene.detected = {false, true};
  scene.step(std::array{shifted(front, -2000.0), door});
  return scene.track_of(1)->id;
}

TEST(Extent, APartInTheObjectsSpaceIsItsOwnWhereverItsEdgesAreSeen) {
  const ImageExtent extent = extent_of(rectangle(90, 20, 380, 240), kSigma_px);
  EXPECT_EQ(id_of_part(columns(90.0, 380.0), extent), 1U);
  EXPECT_EQ(id_of_part(columns(90.0, 310.0), extent), 2U) << "beside it";
  EXPECT_EQ(id_of_part({}, extent), 2U);
}

TEST(Extent, FewFeaturesTakeNoPartFromFarAway) {
  const ImageExtent elsewhere = extent_of(rectangle(90, 60, 310, 200), kSigma_px);
  EXPECT_EQ(id_of_part(columns(90.0, 310.0), elsewhere, 1), 2U);
  EXPECT_EQ(id_of_part(columns(90.0, 380.0), extent_of(rectangle(90, 20, 380, 240), kSigma_px), 1), 1U);
}

/// Number of tracks where a region appears beside the detected mask of a vehicle whose space is `volume`.
std::size_t tracks_with_region(const PredictedVolume& volume, std::uint16_t region_class) {
  const Shape front = rectangle(100, 60, 300, 200);
  Shape rear = rectangle(330, 90, 370, 130);
  rear.class_id = region_class;
  TrackerScene scene({}, 12);
  scene.detected = {true, false};
  for (int i = 0; i < 4; ++i) {
    scene.step(std::array{front, rear});
  }
  ObjectPrediction prediction{.known = true, .point_px = {front.x, front.y}, .depth_m = 10.0};
  prediction.volume = volume;
  scene.object_predictions.assign(1, prediction);
  scene.detected = {true, true};
  return scene.step(std::array{front, rear}).tracks.size();
}

TEST(Extent, AMovingRegionInTheSpaceOfADetectedVehicleIsNoNewObject) {
  EXPECT_EQ(tracks_with_region(columns(90.0, 380.0), kUnknownClass), 1U);
  EXPECT_EQ(tracks_with_region(columns(90.0, 310.0), kUnknownClass), 2U) << "beside it";
  EXPECT_EQ(tracks_with_region(columns(90.0, 380.0), kVehicleClass), 2U) << "a network has seen two";
}

}  // namespace
}  // namespace kinetrace::tracking

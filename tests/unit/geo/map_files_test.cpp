#include "kinetrace/geo/map_files.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace kinetrace::geo {
namespace {

using testing::HasSubstr;

MapPoint point(std::int64_t frame, double east_m, bool is_after_gap = false) {
  MapPoint p;
  p.frame = frame;
  p.timestamp_ns = 1'317'042'145'000'000'000 + frame * 100'000'000;
  p.enu_m = {east_m, 2.0, 3.0};
  p.heading_deg = 90.0;
  p.status = "tracked";
  p.is_after_gap = is_after_gap;
  return p;
}

const MapFileContext kContext{*LocalFrame::at({49.011, 8.416, 116.4}), 0.5};

std::vector<MapTrajectory> two() {
  return {{0, "camera", true, {point(0, 0.0), point(1, 1.0), point(2, 2.0)}},
          {7, "car", true, {point(0, 10.0), point(5, 11.0, true), point(6, 12.0)}}};
}

TEST(GeoJson, HasAFeatureForEachTrajectoryInItsPieces) {
  const auto json = nlohmann::json::parse(geojson_text(two(), kContext));
  EXPECT_EQ(json["type"], "FeatureCollection");
  ASSERT_EQ(json["features"].size(), 2U);
  const auto& car = json["features"][1];
  EXPECT_EQ(car["properties"]["name"], "car 7");
  EXPECT_EQ(car["properties"]["track_id"], 7);
  // The reference's time: half a second before the camera's.
  EXPECT_EQ(car["properties"]["begin"], "2011-09-26T13:02:24.500Z");
  const auto& lines = car["geometry"]["coordinates"];
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_EQ(lines[0].size(), 2U);  // One point alone, twice: RFC 7946, sec. 3.1.4.
  ASSERT_EQ(lines[1].size(), 2U);
  EXPECT_NEAR(lines[1][0][0].get<double>(), 8.41615, 1e-5);  // Longitude first.
  EXPECT_NEAR(lines[1][0][1].get<double>(), 49.01102, 1e-5);
  EXPECT_NEAR(lines[1][0][2].get<double>(), 119.4, 1e-3);
}

TEST(GeoJson, OfNothingIsACollectionOfNothing) {
  EXPECT_TRUE(nlohmann::json::parse(geojson_text({}, kContext))["features"].empty());
}

TEST(Kml, HasAPlacemarkForEachTrajectory) {
  const std::string text = kml_text(two(), kContext);
  EXPECT_THAT(text, HasSubstr("<Placemark><name>camera</name>"));
  EXPECT_THAT(text, HasSubstr("<Placemark><name>car 7</name><styleUrl>#moving</styleUrl>"));
  EXPECT_THAT(text, HasSubstr("<altitudeMode>absolute</altitudeMode>"));
  EXPECT_THAT(text, HasSubstr("8.416000000,49.011017984,119.400"));
}

TEST(Gpx, HasATrackForEachTrajectoryAndASegmentForEachPiece) {
  const std::string text = gpx_text(two(), kContext);
  EXPECT_THAT(text, HasSubstr("<trk><name>car 7</name><type>car</type>\n<trkseg>\n<trkpt"));
  EXPECT_THAT(text, HasSubstr("</trkseg>\n<trkseg>\n"));
  EXPECT_THAT(text, HasSubstr("<time>2011-09-26T13:02:24.500Z</time>"));
}

TEST(Csv, HasARowForEachTrajectoryAndFrame) {
  const std::string text = csv_text(two(), kContext);
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 7);
  EXPECT_THAT(text, HasSubstr("\n5,1317042145500000000,1317042145000000000,7,car,tracked,49.0110"));
  EXPECT_THAT(text, HasSubstr(",32N,4573"));
}

TEST(Csv, HasEveryDigitOfALargeNumber) {
  std::vector<MapTrajectory> trajectories = two();
  for (MapTrajectory& trajectory : trajectories) {
    for (MapPoint& point : trajectory.points) {
      point.velocity_mps.setConstant(1e308);
    }
  }
  const std::string text = csv_text(trajectories, kContext);
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 7);
  EXPECT_EQ(std::count(text.begin(), text.end(), ','), 7 * 19);
  EXPECT_TRUE(text.ends_with(",90.00,0.000\n"));
  EXPECT_EQ(text.find('\0'), std::string::npos);
}

TEST(MapFiles, BeginWithWhatTheyAreRecognisedBy) {
  EXPECT_TRUE(geojson_text(two(), kContext).starts_with(kGeoJsonBegin));
  EXPECT_TRUE(kml_text(two(), kContext).starts_with(kKmlBegin));
  EXPECT_TRUE(gpx_text(two(), kContext).starts_with(kGpxBegin));
  EXPECT_TRUE(csv_text(two(), kContext).starts_with(kCsvBegin));
}

}  // namespace
}  // namespace kinetrace::geo

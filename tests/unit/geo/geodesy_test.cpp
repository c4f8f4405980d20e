#include "kinetrace/geo/geodesy.hpp"

#include <limits>

#include <gtest/gtest.h>

namespace kinetrace::geo {
namespace {

constexpr Geodetic kKarlsruhe{49.011, 8.416, 116.4};

TEST(LocalFrame, ItsAxesAreEastNorthAndUp) {
  const LocalFrame frame = *LocalFrame::at(kKarlsruhe);
  EXPECT_LT(frame.to_enu(kKarlsruhe).norm(), 1e-6);
  // A thousandth of a degree of latitude is 111.2 m there, one of longitude 73.2 m (ellipsoid's radii of curvature).
  const Eigen::Vector3d north = frame.to_enu({49.012, 8.416, 116.4});
  EXPECT_NEAR(north.y(), 111.21, 0.02);
  EXPECT_NEAR(north.x(), 0.0, 1e-6);
  const Eigen::Vector3d east = frame.to_enu({49.011, 8.417, 116.4});
  EXPECT_NEAR(east.x(), 73.16, 0.03);
  const Eigen::Vector3d up = frame.to_enu({49.011, 8.416, 126.4});
  EXPECT_LT((up - Eigen::Vector3d(0.0, 0.0, 10.0)).norm(), 1e-6);
}

TEST(LocalFrame, ReturnsToTheSamePlaceEverywhereOnEarth) {
  for (const Geodetic& origin : {kKarlsruhe, Geodetic{0, 0, 0}, Geodetic{-33.9, 151.2, 20}, Geodetic{64.1, -21.9, -10},
                                 Geodetic{89.999, 179.999, 0}, Geodetic{-89.0, -179.999, 2800}}) {
    const LocalFrame frame = *LocalFrame::at(origin);
    const Eigen::Vector3d p(1234.5, -987.6, 55.0);
    EXPECT_LT((frame.to_enu(frame.to_geodetic(p)) - p).norm(), 1e-6);
  }
}

TEST(LocalFrame, RefusesWhatIsNoPlace) {
  for (const Geodetic& origin : {Geodetic{91, 0, 0}, Geodetic{0, 181, 0}, Geodetic{0, 0, 1e6},
                                 Geodetic{std::numeric_limits<double>::quiet_NaN(), 0, 0},
                                 Geodetic{0, std::numeric_limits<double>::infinity(), 0}}) {
    const auto frame = LocalFrame::at(origin);
    ASSERT_FALSE(frame);
    EXPECT_EQ(frame.error().code, ErrorCode::kInvalidArgument);
  }
}

// Zone 32 has its central meridian at 9 degrees east, where the easting is 500 km and the scale 0.9996.
TEST(Utm, HasItsKnownValues) {
  const UtmPoint middle = to_utm({0.0, 9.0, 0.0});
  EXPECT_EQ(middle.zone, 32);
  EXPECT_TRUE(middle.is_northern);
  EXPECT_NEAR(middle.easting_m, 500'000.0, 1e-6);
  EXPECT_NEAR(middle.northing_m, 0.0, 1e-6);
  const UtmPoint south = to_utm({-33.9, 151.2, 0.0});
  EXPECT_EQ(south.zone, 56);
  EXPECT_FALSE(south.is_northern);
  EXPECT_EQ(to_utm({85.0, 0.0, 0.0}).zone, 0);
}

TEST(Utm, StaysInTheZoneThatIsAskedFor) {
  EXPECT_EQ(to_utm({49.0, 12.001, 0.0}).zone, 33);
  const UtmPoint point = to_utm({49.0, 12.001, 0.0}, 32);
  EXPECT_EQ(point.zone, 32);
  EXPECT_GT(point.easting_m, 700'000.0);
}

}  // namespace
}  // namespace kinetrace::geo

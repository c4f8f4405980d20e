// Positions on the Earth: WGS84, a local frame of metres, UTM.
#pragma once

#include <Eigen/Core>

#include "kinetrace/core/result.hpp"

namespace kinetrace::geo {

/// A position in WGS84.
struct Geodetic {
  double latitude_deg = 0.0;   ///< [-90, 90].
  double longitude_deg = 0.0;  ///< [-180, 180].
  double height_m = 0.0;       ///< Above the ellipsoid, not above the sea.
};

/// Whether it is near the Earth's surface: finite, latitude and longitude in range, height from -12 to 100 km (the
/// deepest sea, the edge of space).
[[nodiscard]] bool is_valid(const Geodetic& place) noexcept;

/// Universal Transverse Mercator; beyond 84 degrees north and 80 degrees south Universal Polar Stereographic.
struct UtmPoint {
  int zone = 0;  ///< 1 to 60; 0 is UPS.
  bool is_northern = true;
  double easting_m = 0.0;
  double northing_m = 0.0;
};
/// `place` is valid. `zone`: a fixed zone, so that it does not change along a path; below 0: the place's own.
[[nodiscard]] UtmPoint to_utm(const Geodetic& place, int zone = -1);

/// East, north and up in metres about an origin: the map frame, a plane that touches the ellipsoid there (Farrell,
/// "Aided Navigation", 2008, sec. 2.5.3). Frame of ROS REP 103.
class LocalFrame {
 public:
  /// Errors: kInvalidArgument (the origin is not valid).
  [[nodiscard]] static Result<LocalFrame> at(const Geodetic& origin);

  [[nodiscard]] const Geodetic& origin() const noexcept { return origin_; }
  /// `place` is valid.
  [[nodiscard]] Eigen::Vector3d to_enu(const Geodetic& place) const;
  [[nodiscard]] Geodetic to_geodetic(const Eigen::Vector3d& enu_m) const;

 private:
  Geodetic origin_;
  Eigen::Vector3d origin_ecef_m_ = Eigen::Vector3d::Zero();
  Eigen::Matrix3d R_ecef_enu_ = Eigen::Matrix3d::Identity();
};

}  // namespace kinetrace::geo

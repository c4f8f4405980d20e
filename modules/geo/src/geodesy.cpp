#include "kinetrace/geo/geodesy.hpp"

#include <GeographicLib/Geocentric.hpp>
#include <GeographicLib/UTMUPS.hpp>
#include <cmath>

namespace kinetrace::geo {
namespace {

Eigen::Vector3d to_ecef(const Geodetic& place) {
  Eigen::Vector3d p;
  GeographicLib::Geocentric::WGS84().Forward(place.latitude_deg, place.longitude_deg, place.height_m, p.x(), p.y(),
                                             p.z());
  return p;
}

/// Columns: east, north and up at the place, in Earth-centred axes.
Eigen::Matrix3d enu_axes(const Geodetic& place) {
  const double latitude = place.latitude_deg * M_PI / 180.0;
  const double longitude = place.longitude_deg * M_PI / 180.0;
  const double s_lat = std::sin(latitude);
  const double c_lat = std::cos(latitude);
  const double s_lon = std::sin(longitude);
  const double c_lon = std::cos(longitude);
  Eigen::Matrix3d axes;
  axes.col(0) << -s_lon, c_lon, 0.0;
  axes.col(1) << -s_lat * c_lon, -s_lat * s_lon, c_lat;
  axes.col(2) << c_lat * c_lon, c_lat * s_lon, s_lat;
  return axes;
}

}  // namespace

bool is_valid(const Geodetic& place) noexcept {
  // Written so that NaN fails.
  return std::abs(place.latitude_deg) <= 90.0 && std::abs(place.longitude_deg) <= 180.0 && place.height_m >= -12e3 &&
         place.height_m <= 100e3;
}

UtmPoint to_utm(const Geodetic& place, int zone) {
  UtmPoint point;
  const int wanted = zone < 0 ? static_cast<int>(GeographicLib::UTMUPS::STANDARD) : zone;
  GeographicLib::UTMUPS::Forward(place.latitude_deg, place.longitude_deg, point.zone, point.is_northern,
                                 point.easting_m, point.northing_m, wanted);
  return point;
}

Result<LocalFrame> LocalFrame::at(const Geodetic& origin) {
  if (!is_valid(origin)) {
    return fail(ErrorCode::kInvalidArgument, "no place of WGS84: latitude " + std::to_string(origin.latitude_deg) +
                                                 ", longitude " + std::to_string(origin.longitude_deg) + ", height " +
                                                 std::to_string(origin.height_m) +
                                                 "; degrees within 90 and 180, metres above the ellipsoid");
  }
  LocalFrame frame;
  frame.origin_ = origin;
  frame.origin_ecef_m_ = to_ecef(origin);
  frame.R_ecef_enu_ = enu_axes(origin);
  return frame;
}

Eigen::Vector3d LocalFrame::to_enu(const Geodetic& place) const {
  return R_ecef_enu_.transpose() * (to_ecef(place) - origin_ecef_m_);
}

Geodetic LocalFrame::to_geodetic(const Eigen::Vector3d& enu_m) const {
  const Eigen::Vector3d p = R_ecef_enu_ * enu_m + origin_ecef_m_;
  Geodetic place;
  GeographicLib::Geocentric::WGS84().Reverse(p.x(), p.y(), p.z(), place.latitude_deg, place.longitude_deg,
                                             place.height_m);
  return place;
}

}  // namespace kinetrace::geo

// Trajectories in WGS84 as texts for maps and tables.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "kinetrace/geo/geodesy.hpp"

namespace kinetrace::geo {

/// Position of the camera or an object in one frame.
struct MapPoint {
  std::int64_t frame = 0;
  std::int64_t timestamp_ns = 0;                           ///< Of the camera's clock.
  Eigen::Vector3d enu_m = Eigen::Vector3d::Zero();         ///< In the map frame.
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();  ///< East, north, up.
  double heading_deg = 0.0;                                ///< Clockwise from north, [0, 360).
  double sigma_m = 0.0;       ///< Horizontal standard deviation by the alignment alone, in the worst direction.
  std::string_view status;    ///< As in objects.csv.
  bool is_after_gap = false;  ///< Frames are missing before this one: lines are interrupted.
};

struct MapTrajectory {
  std::uint32_t id = 0;  ///< Track id; 0 is the camera.
  std::string kind;      ///< "camera", or the object's class.
  bool moving = false;
  std::vector<MapPoint> points;  ///< By frame; at least one.

  [[nodiscard]] std::string name() const { return id == 0 ? kind : kind + " " + std::to_string(id); }
};

/// Data common to all files besides the trajectories.
struct MapFileContext {
  LocalFrame frame;
  double time_offset_s =
      0.0;  ///< Camera's clock minus the reference's: files with UTC have times of the reference's clock.
};

// Each file begins with one of these, by which an earlier map is recognised.
inline constexpr std::string_view kGeoJsonBegin = "{\"type\":\"FeatureCollection\",\"features\":[\n";
inline constexpr std::string_view kKmlBegin =
    "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<kml xmlns=\"http://www.opengis.net/kml/2.2\"><Document>\n"
    "<name>Kinetrace</name>\n";
inline constexpr std::string_view kGpxBegin =
    "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
    "<gpx version=\"1.1\" creator=\"Kinetrace\" xmlns=\"http://www.topografix.com/GPX/1/1\">\n";
inline constexpr std::string_view kCsvBegin =
    "frame,timestamp_ns,reference_ns,track_id,class,status,latitude,longitude,height,utm_zone,utm_easting,"
    "utm_northing,east,north,up,v_east,v_north,v_up,heading,sigma\n";

/// RFC 7946: a FeatureCollection with a feature for each trajectory; longitude, latitude, height above the ellipsoid.
[[nodiscard]] std::string geojson_text(std::span<const MapTrajectory> trajectories, const MapFileContext& context);
/// OGC KML 2.2: a placemark for each trajectory; heights are absolute.
[[nodiscard]] std::string kml_text(std::span<const MapTrajectory> trajectories, const MapFileContext& context);
/// GPX 1.1: a track for each trajectory, with time in UTC.
[[nodiscard]] std::string gpx_text(std::span<const MapTrajectory> trajectories, const MapFileContext& context);
/// One row for each trajectory and frame, with UTM of the zone in which the map's origin lies; see the README.
[[nodiscard]] std::string csv_text(std::span<const MapTrajectory> trajectories, const MapFileContext& context);

}  // namespace kinetrace::geo

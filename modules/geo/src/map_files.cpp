#include "kinetrace/geo/map_files.hpp"

#include <cmath>
#include <cstdio>

#include "utc_time.hpp"

namespace kinetrace::geo {
namespace {

/// Appends printf output to a text.
template <typename... Values>
void append(std::string& text, const char* format, Values... values) {
  char piece[512];
  const auto length = static_cast<std::size_t>(std::snprintf(piece, sizeof piece, format, values...));
  if (length < sizeof piece) {
    text.append(piece, length);
    return;
  }
  // A number may have more than 300 digits.
  const std::size_t begin = text.size();
  text.resize(begin + length + 1);
  std::snprintf(text.data() + begin, length + 1, format, values...);
  text.pop_back();
}

std::int64_t reference_time_ns(const MapPoint& point, const MapFileContext& context) {
  return point.timestamp_ns - std::llround(context.time_offset_s * 1e9);
}

/// Trajectories split at gaps. A line needs two points: single points are duplicated.
std::vector<std::vector<const MapPoint*>> stretches(const MapTrajectory& trajectory) {
  std::vector<std::vector<const MapPoint*>> parts;
  for (const MapPoint& point : trajectory.points) {
    if (parts.empty() || point.is_after_gap) {
      parts.emplace_back();
    }
    parts.back().push_back(&point);
  }
  for (auto& part : parts) {
    if (part.size() == 1) {
      part.push_back(part.front());
    }
  }
  return parts;
}

std::string times_of(const MapTrajectory& trajectory, const MapFileContext& context, const char* format) {
  std::string text;
  append(text, format, date_time_text(reference_time_ns(trajectory.points.front(), context)).c_str(),
         date_time_text(reference_time_ns(trajectory.points.back(), context)).c_str());
  return text;
}

void append_feature(std::string& text, const MapTrajectory& trajectory, const MapFileContext& context) {
  append(text, "{\"type\":\"Feature\",\"properties\":{\"name\":\"%s\",\"track_id\":%u,\"class\":\"%s\",\"moving\":%s,",
         trajectory.name().c_str(), trajectory.id, trajectory.kind.c_str(), trajectory.moving ? "true" : "false");
  text += times_of(trajectory, context, "\"begin\":\"%s\",\"end\":\"%s\"},");
  text += "\"geometry\":{\"type\":\"MultiLineString\",\"coordinates\":[";
  const char* between_parts = "";
  for (const auto& part : stretches(trajectory)) {
    append(text, "%s[", between_parts);
    const char* between = "";
    for (const MapPoint* point : part) {
      const Geodetic place = context.frame.to_geodetic(point->enu_m);
      append(text, "%s[%.9f,%.9f,%.3f]", between, place.longitude_deg, place.latitude_deg, place.height_m);
      between = ",";
    }
    text += "]";
    between_parts = ",";
  }
  text += "]}}";
}

void append_placemark(std::string& text, const MapTrajectory& trajectory, const MapFileContext& context) {
  const char* const style = trajectory.id == 0 ? "camera" : trajectory.moving ? "moving" : "standing";
  append(text, "<Placemark><name>%s</name><styleUrl>#%s</styleUrl>\n", trajectory.name().c_str(), style);
  text += times_of(trajectory, context, "<TimeSpan><begin>%s</begin><end>%s</end></TimeSpan>\n<MultiGeometry>\n");
  for (const auto& part : stretches(trajectory)) {
    text += "<LineString><altitudeMode>absolute</altitudeMode><coordinates>\n";
    for (const MapPoint* point : part) {
      const Geodetic place = context.frame.to_geodetic(point->enu_m);
      append(text, "%.9f,%.9f,%.3f\n", place.longitude_deg, place.latitude_deg, place.height_m);
    }
    text += "</coordinates></LineString>\n";
  }
  text += "</MultiGeometry></Placemark>\n";
}

void append_track(std::string& text, const MapTrajectory& trajectory, const MapFileContext& context) {
  append(text, "<trk><name>%s</name><type>%s</type>\n", trajectory.name().c_str(), trajectory.kind.c_str());
  const char* end = "<trkseg>\n";
  for (const MapPoint& point : trajectory.points) {
    if (point.is_after_gap || &point == &trajectory.points.front()) {
      text += end;
      end = "</trkseg>\n<trkseg>\n";
    }
    const Geodetic place = context.frame.to_geodetic(point.enu_m);
    append(text, "<trkpt lat=\"%.9f\" lon=\"%.9f\"><ele>%.3f</ele><time>%s</time></trkpt>\n", place.latitude_deg,
           place.longitude_deg, place.height_m, date_time_text(reference_time_ns(point, context)).c_str());
  }
  text += "</trkseg>\n</trk>\n";
}

}  // namespace

std::string geojson_text(std::span<const MapTrajectory> trajectories, const MapFileContext& context) {
  std::string text(kGeoJsonBegin);
  const char* between = "";
  for (const MapTrajectory& trajectory : trajectories) {
    text += between;
    append_feature(text, trajectory, context);
    between = ",\n";
  }
  return text + "\n]}\n";
}

std::string kml_text(std::span<const MapTrajectory> trajectories, const MapFileContext& context) {
  std::string text(kKmlBegin);
  text +=
      "<Style id=\"camera\"><LineStyle><color>ff000000</color><width>4</width></LineStyle></Style>\n"
      "<Style id=\"moving\"><LineStyle><color>ff005ed5</color><width>4</width></LineStyle></Style>\n"
      "<Style id=\"standing\"><LineStyle><color>ffb27200</color><width>3</width></LineStyle></Style>\n";
  for (const MapTrajectory& trajectory : trajectories) {
    append_placemark(text, trajectory, context);
  }
  return text + "</Document></kml>\n";
}

std::string gpx_text(std::span<const MapTrajectory> trajectories, const MapFileContext& context) {
  std::string text(kGpxBegin);
  for (const MapTrajectory& trajectory : trajectories) {
    append_track(text, trajectory, context);
  }
  return text + "</gpx>\n";
}

std::string csv_text(std::span<const MapTrajectory> trajectories, const MapFileContext& context) {
  std::string text(kCsvBegin);
  const int zone = to_utm(context.frame.origin()).zone;
  for (const MapTrajectory& trajectory : trajectories) {
    for (const MapPoint& point : trajectory.points) {
      const Geodetic place = context.frame.to_geodetic(point.enu_m);
      const UtmPoint utm = to_utm(place, zone);
      append(text, "%lld,%lld,%lld,%u,%s,%.*s,", static_cast<long long>(point.frame),
             static_cast<long long>(point.timestamp_ns), static_cast<long long>(reference_time_ns(point, context)),
             trajectory.id, trajectory.kind.c_str(), static_cast<int>(point.status.size()), point.status.data());
      append(text, "%.9f,%.9f,%.3f,%d%c,%.3f,%.3f,", place.latitude_deg, place.longitude_deg, place.height_m, utm.zone,
             utm.is_northern ? 'N' : 'S', utm.easting_m, utm.northing_m);
      append(text, "%.3f,%.3f,%.3f,%.3f,%.3f,%.3f,%.2f,%.3f\n", point.enu_m.x(), point.enu_m.y(), point.enu_m.z(),
             point.velocity_mps.x(), point.velocity_mps.y(), point.velocity_mps.z(), point.heading_deg, point.sigma_m);
    }
  }
  return text;
}

}  // namespace kinetrace::geo

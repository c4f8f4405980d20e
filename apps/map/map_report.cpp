#include "map_report.hpp"

#include <array>
#include <cmath>
#include <cstdio>

#include <nlohmann/json.hpp>

namespace kinetrace::map {
namespace {

using nlohmann::ordered_json;

constexpr double kDegrees = 180.0 / M_PI;

template <typename Vector>
ordered_json numbers(const Vector& values) {
  ordered_json list = ordered_json::array();
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    list.push_back(values(i));
  }
  return list;
}

/// Row by row.
template <typename Matrix>
ordered_json rows(const Matrix& matrix) {
  ordered_json list = ordered_json::array();
  for (Eigen::Index r = 0; r < matrix.rows(); ++r) {
    for (Eigen::Index c = 0; c < matrix.cols(); ++c) {
      list.push_back(matrix(r, c));
    }
  }
  return list;
}

ordered_json reference_json(const MapReport& report) {
  const geo::ReferenceCounts& counts = report.reference.counts;
  return {{"format", report.format},
          {"path", report.path},
          {"records", counts.records},
          {"fixes", report.reference.fixes.size()},
          {"bad_checksums", counts.bad_checksums},
          {"malformed", counts.malformed},
          {"without_fix", counts.without_fix},
          {"repeated", counts.repeated},
          {"out_of_order", counts.out_of_order},
          {"gaps", counts.gaps},
          {"longest_gap_s", counts.longest_gap_s},
          {"jumps", counts.jumps},
          {"notes", report.reference.notes}};
}

ordered_json map_json(const MapReport& report) {
  const geo::Geodetic& origin = report.reference.frame.origin();
  const geo::UtmPoint utm = geo::to_utm(origin);
  const Se3& T = report.alignment.T_map_world;
  Eigen::Matrix<double, 3, 4> matrix;
  matrix << T.rotation, T.translation;
  return {
      {"origin", {{"latitude", origin.latitude_deg}, {"longitude", origin.longitude_deg}, {"height", origin.height_m}}},
      {"utm_zone", std::to_string(utm.zone) + (utm.is_northern ? 'N' : 'S')},
      {"T_map_world", rows(matrix)}};
}

/// REP 105: `odom` is the world with its axes turned to forward, left and up.
ordered_json ros_json(const geo::Alignment& alignment) {
  Eigen::Matrix3d R_world_odom;
  R_world_odom << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  const Eigen::Quaterniond q(alignment.T_map_world.rotation * R_world_odom);
  return {{"parent", "map"},
          {"child", "odom"},
          {"translation", numbers(alignment.T_map_world.translation)},
          {"rotation_xyzw", numbers(q.normalized().coeffs())}};
}

Eigen::Vector3d sigmas(const geo::Alignment& alignment, Eigen::Index first) {
  return alignment.covariance.diagonal().segment<3>(first).cwiseMax(0.0).cwiseSqrt();
}

/// printf into a string.
template <typename... Values>
std::string line(const char* format, Values... values) {
  std::array<char, 512> text{};
  std::snprintf(text.data(), text.size(), format, values...);
  return text.data();
}

/// False: refused before anything was estimated.
bool has_estimate(const geo::Alignment& alignment) {
  return !alignment.covariance.isZero(0.0);
}

std::string reference_text(const MapReport& report) {
  const geo::ReferenceCounts& counts = report.reference.counts;
  std::string text = line("reference  %zu fixes of ", report.reference.fixes.size());
  text += report.path;
  text += line(" (%s); in the camera's time %lld, of these outliers %lld\n", report.format.c_str(),
               static_cast<long long>(report.alignment.fixes),
               static_cast<long long>(report.alignment.fixes - report.alignment.inliers));
  const std::array<std::pair<const char*, std::int64_t>, 7> irregular{{{"bad checksums", counts.bad_checksums},
                                                                       {"malformed", counts.malformed},
                                                                       {"without fix", counts.without_fix},
                                                                       {"repeated", counts.repeated},
                                                                       {"out of order", counts.out_of_order},
                                                                       {"gaps", counts.gaps},
                                                                       {"jumps", counts.jumps}}};
  std::string list;
  for (const auto& [name, count] : irregular) {
    if (count > 0) {
      list += line("%s%s %lld", list.empty() ? "" : ", ", name, static_cast<long long>(count));
    }
  }
  return list.empty() ? text : text + "           " + list + '\n';
}

}  // namespace

std::string report_json(const MapReport& report, int indent) {
  const geo::Alignment& alignment = report.alignment;
  const bool is_aligned = alignment.verdict == geo::Verdict::kAligned;
  ordered_json json{{"verdict", is_aligned ? "aligned" : "refused"},
                    {"reason", is_aligned ? ordered_json() : ordered_json(alignment.reason)},
                    {"run", report.run},
                    {"reference", reference_json(report)},
                    {"degrees_of_freedom", static_cast<int>(report.config.freedom)},
                    {"lever_arm_m", numbers(report.config.lever_arm_m)},
                    {"path_m", alignment.path_m},
                    {"path_drift", report.config.path_drift},
                    {"fixes",
                     {{"matched", alignment.fixes},
                      {"inliers", alignment.inliers},
                      {"unmatched", alignment.unmatched},
                      {"horizontal_noise_m", alignment.horizontal_noise_m},
                      {"vertical_noise_m", alignment.vertical_noise_m},
                      {"correlation", alignment.correlation}}},
                    {"time_offset_s", alignment.time_offset_s},
                    {"time_offset_sigma_s", alignment.time_offset_sigma_s},
                    {"time_offset_searched_s", report.config.max_time_offset_s},
                    {"center_m", numbers(alignment.center_m)},
                    {"rotation_sigma_deg", numbers((sigmas(alignment, 0) * kDegrees).eval())},
                    {"position_sigma_m", numbers(sigmas(alignment, 3))},
                    {"covariance", rows(alignment.covariance)},
                    {"scale", alignment.scale},
                    {"scale_sigma", alignment.scale_sigma}};
  if (!has_estimate(alignment)) {
    for (const char* name : {"time_offset_s", "time_offset_sigma_s", "center_m", "rotation_sigma_deg",
                             "position_sigma_m", "covariance", "scale", "scale_sigma"}) {
      json[name] = nullptr;
    }
    for (const char* name : {"horizontal_noise_m", "vertical_noise_m", "correlation"}) {
      json["fixes"][name] = nullptr;
    }
  }
  if (is_aligned) {
    json["map"] = map_json(report);
    json["ros"] = ros_json(alignment);
  }
  return json.dump(indent, ' ', false, ordered_json::error_handler_t::replace) + '\n';
}

std::string report_text(const MapReport& report) {
  const geo::Alignment& alignment = report.alignment;
  const Eigen::Vector3d rotation_deg = sigmas(alignment, 0) * kDegrees;
  const Eigen::Vector3d position_m = sigmas(alignment, 3);
  std::string text = reference_text(report);
  if (!has_estimate(alignment)) {
    return text;
  }
  text += line("noise      %.2f m horizontally, %.2f m in height; %.1f neighbouring fixes are worth one\n",
               alignment.horizontal_noise_m, alignment.vertical_noise_m, alignment.correlation);
  text += line("offset     camera's clock minus the reference's %+.3f s, sigma %.3f s\n", alignment.time_offset_s,
               alignment.time_offset_sigma_s);
  text += line(
      "alignment  %d degrees of freedom; sigmas of the rotation about east, north, up %.2f %.2f %.2f degrees,\n"
      "           of the position %.2f %.2f %.2f m; path of %.1f m\n",
      static_cast<int>(report.config.freedom), rotation_deg.x(), rotation_deg.y(), rotation_deg.z(), position_m.x(),
      position_m.y(), position_m.z(), alignment.path_m);
  text += line("scale      %.4f, sigma %.4f: the reference's length by the path's; not applied\n", alignment.scale,
               alignment.scale_sigma);
  return text;
}

}  // namespace kinetrace::map

#include "self_report.hpp"

#include <array>
#include <cmath>

#include <nlohmann/json.hpp>

#include "kinetrace/core/rig_correction.hpp"
#include "report_text.hpp"

namespace kinetrace::self_calibration {
namespace {

using Json = nlohmann::ordered_json;
using calibration::formatted;
using calibration::kDegrees;

constexpr std::array<const char*, kLensSize> kLensNames{"ln(fx/width)", "ln(fy/fx)", "cx/width", "cy/width", "k1",
                                                        "k2",           "p1",        "p2",       "k3"};
constexpr std::array<const char*, kMountSize> kMountNames{"turn_x_rad", "turn_y_rad", "turn_z_rad", "baseline_y/x",
                                                          "baseline_z/x"};

double sigma(const SelfCalibration& result, int parameter) {
  return std::sqrt(result.covariance(parameter, parameter));
}

std::string camera_line(const char* name, const SelfCalibration& result, const hal::CameraModel& camera, int first) {
  const double width = result.rig.size.width_px;
  return formatted(
      "%-8s fx %.2f +- %.2f, fy %.2f, cx %.2f +- %.2f, cy %.2f +- %.2f px; k1 %.4f k2 %.4f p1 %.5f p2 %.5f k3 %.4f",
      name, camera.fx_px, camera.fx_px * sigma(result, first + kLogFocal), camera.fy_px, camera.cx_px,
      width * sigma(result, first + kOffsetX), camera.cy_px, width * sigma(result, first + kOffsetY),
      camera.distortion[0], camera.distortion[1], camera.distortion[2], camera.distortion[3], camera.distortion[4]);
}

std::string scene_line(const Findings& findings) {
  return formatted(
      "seen     %zu points in %zu stretches, fit to %.3f px; they move %.0f px, %.0f px of it by parallax; depths "
      "differ by a factor of %.1f",
      findings.scene.points, findings.windows, findings.sigma_px, findings.scene.travel_px, findings.scene.parallax_px,
      findings.scene.depth_ratio);
}

Json camera_json(const hal::CameraModel& camera) {
  return {{"fx_px", camera.fx_px},      {"fy_px", camera.fy_px},      {"cx_px", camera.cx_px},
          {"cy_px", camera.cy_px},      {"k1", camera.distortion[0]}, {"k2", camera.distortion[1]},
          {"p1", camera.distortion[2]}, {"p2", camera.distortion[3]}, {"k3", camera.distortion[4]}};
}

Json covariance_json(const RigCovariance& covariance) {
  Json names = Json::array();
  for (const char* view : {"left ", "right "}) {
    for (const char* name : kLensNames) {
      names.push_back(std::string(view) + name);
    }
  }
  for (const char* name : kMountNames) {
    names.push_back(name);
  }
  Json rows = Json::array();
  for (int i = 0; i < kRigSize; ++i) {
    Json row = Json::array();
    for (int j = 0; j < kRigSize; ++j) {
      row.push_back(covariance(i, j));
    }
    rows.push_back(row);
  }
  return {{"parameters", names}, {"matrix", rows}};
}

}  // namespace

std::vector<std::string> report_lines(const SelfCalibration& result) {
  constexpr int kMount = 2 * kLensSize;
  const auto& mount = result.rig.mount;
  std::vector<std::string> lines{
      camera_line("left", result, result.calibration.left, 0),
      camera_line("right", result, result.calibration.right, kLensSize),
      formatted("turn     of the right view %.3f %.3f %.3f +- %.3f %.3f %.3f deg about x, y, z",
                mount[kTurnX] * kDegrees, mount[kTurnY] * kDegrees, mount[kTurnZ] * kDegrees,
                sigma(result, kMount + kTurnX) * kDegrees, sigma(result, kMount + kTurnY) * kDegrees,
                sigma(result, kMount + kTurnZ) * kDegrees),
      scene_line(result.findings)};
  std::string depths = "depth    error to be expected from the calibration:";
  for (const double depth_m : kReportedDepths_m) {
    const double sigma_depth = depth_sigma(result.rig, result.covariance, depth_m);
    depths +=
        formatted("%s %.3f m at %.0f m", depth_m > kReportedDepths_m[0] ? "," : "", sigma_depth * depth_m, depth_m);
  }
  lines.push_back(depths);
  lines.push_back(formatted("accepted focal length to %.2f %%, with the baseline of %.4f m as given",
                            100.0 * result.findings.focal_sigma, result.rig.baseline_m));
  return lines;
}

std::vector<std::string> remarks(const SelfCalibration& result, const std::string& images) {
  return {"Self-calibration from " + images,
          formatted("baseline as given: %.6f m; focal length to %.2f %%; points fit to %.3f px", result.rig.baseline_m,
                    100.0 * result.findings.focal_sigma, result.findings.sigma_px)};
}

std::string report_json(const SelfCalibration& result, const std::string& images) {
  const Findings& findings = result.findings;
  const Se3& T = result.calibration.T_right_left;
  Json json{{"method", "self-calibration"}, {"images", images}, {"verdict", "accepted"}};
  json["left"] = camera_json(result.calibration.left);
  json["right"] = camera_json(result.calibration.right);
  json["baseline_m"] = result.rig.baseline_m;
  json["rotation_vector_rad"] = {result.rig.mount[kTurnX], result.rig.mount[kTurnY], result.rig.mount[kTurnZ]};
  json["translation_m"] = {T.translation.x(), T.translation.y(), T.translation.z()};
  json["seen"] = {{"windows", findings.windows},
                  {"points", findings.scene.points},
                  {"used_share", findings.used_share},
                  {"sigma_px", findings.sigma_px},
                  {"travel_px", findings.scene.travel_px},
                  {"parallax_px", findings.scene.parallax_px},
                  {"depth_ratio", findings.scene.depth_ratio},
                  {"plane_share", findings.scene.plane_share}};
  json["focal_sigma"] = findings.focal_sigma;
  for (const double depth_m : kReportedDepths_m) {
    json["depth_sigma_m"].push_back(
        {{"depth_m", depth_m}, {"sigma_m", depth_m * depth_sigma(result.rig, result.covariance, depth_m)}});
  }
  json["covariance"] = covariance_json(result.covariance);
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace kinetrace::self_calibration

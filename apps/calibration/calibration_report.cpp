#include "calibration_report.hpp"

#include <nlohmann/json.hpp>

#include "kinetrace/core/config_check.hpp"
#include "kinetrace/core/files.hpp"
#include "kinetrace/imaging/image_info.hpp"
#include "report_text.hpp"

namespace kinetrace::calibration {
namespace {

using Json = nlohmann::ordered_json;

std::string camera_line(const char* name, const hal::CameraModel& camera, const ParameterVector& sigmas, int first) {
  return formatted("%-8s fx %.2f +- %.2f, fy %.2f +- %.2f, cx %.2f +- %.2f, cy %.2f +- %.2f px", name, camera.fx_px,
                   sigmas(first), camera.fy_px, sigmas(first + 1), camera.cx_px, sigmas(first + 2), camera.cy_px,
                   sigmas(first + 3));
}

std::string lens_line(const hal::CameraModel& camera, const ParameterVector& sigmas, int first) {
  std::string line = "         distortion";
  for (int i = 0; i < 8; ++i) {
    if (sigmas(first + 4 + i) > 0.0) {
      line += formatted(" %.5f +- %.5f", camera.distortion[static_cast<std::size_t>(i)], sigmas(first + 4 + i));
    }
  }
  return line;
}

Json camera_json(const hal::CameraModel& camera, double rms_px) {
  return {{"model", camera.lens == hal::LensModel::kEquidistant ? "equidistant" : "radial-tangential"},
          {"width_px", camera.width_px},
          {"height_px", camera.height_px},
          {"fx_px", camera.fx_px},
          {"fy_px", camera.fy_px},
          {"cx_px", camera.cx_px},
          {"cy_px", camera.cy_px},
          {"distortion", camera.distortion},
          {"reprojection_rms_px", rms_px}};
}

Json pose_json(const Se3& pose) {
  Json rows = Json::array();
  for (int row = 0; row < 3; ++row) {
    rows.push_back({pose.rotation(row, 0), pose.rotation(row, 1), pose.rotation(row, 2), pose.translation(row)});
  }
  return rows;
}

Json covariance_json(const ParameterMatrix& covariance) {
  std::vector<int> free;
  for (int i = 0; i < kParameters; ++i) {
    if (covariance(i, i) > 0.0) {
      free.push_back(i);
    }
  }
  Json names = Json::array();
  Json rows = Json::array();
  for (const int i : free) {
    names.push_back(parameter_name(i));
    Json row = Json::array();
    for (const int j : free) {
      row.push_back(covariance(i, j));
    }
    rows.push_back(std::move(row));
  }
  return {{"parameters", std::move(names)}, {"matrix", std::move(rows)}};
}

Json views_json(const TargetCalibration& calibration, const ViewCollector& views) {
  const Assessment assessment = views.assess();
  return {{"taken", assessment.views},
          {"used", calibration.estimate.used_views.size()},
          {"rejected", calibration.estimate.rejected_views},
          {"rejected_corners", calibration.estimate.rejected_corners},
          {"similar", views.count(Offer::kSimilar)},
          {"in_one_image_only", views.count(Offer::kOneImageOnly)},
          {"without_target", views.count(Offer::kNoTarget)},
          {"left_coverage", assessment.left_coverage},
          {"right_coverage", assessment.right_coverage},
          {"largest_tilt_deg", assessment.largest_tilt_rad * kDegrees},
          {"nearest_m", assessment.nearest_m},
          {"farthest_m", assessment.farthest_m}};
}

Status make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error || !std::filesystem::is_directory(folder, error)) {
    return fail(ErrorCode::kIo, folder.string() + ": " + (error ? error.message() : "is no folder") +
                                    "; name another folder for the calibration");
  }
  return {};
}

/// Folders to be made for this one, the innermost first.
std::vector<std::filesystem::path> missing_folders(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> missing;
  std::error_code error;
  for (std::filesystem::path each = folder; !each.empty() && !std::filesystem::exists(each, error);
       each = each.parent_path()) {
    missing.push_back(each);
  }
  return missing;
}

// Files of an earlier calibration are replaced, others of these names are not.
Status check_places(const std::filesystem::path& folder) {
  using Path = std::filesystem::path;
  return first_failure(
      {hal::check_calibration_place(folder / "calibration.yaml", hal::CalibrationFormat::kOpencv),
       hal::check_calibration_place(folder / "camchain.yaml", hal::CalibrationFormat::kKalibr),
       check_same_kind(folder / "calibration.json", {"report of a calibration",
                                                     [](const Path& path) {
                                                       return begins_with(path, "{\n  \"images\": ") ||
                                                              begins_with(path, "{\n  \"method\": ");
                                                     }}),
       check_same_kind(folder / "calibration.png", {"picture of a calibration", &imaging::is_drawn_picture})});
}

}  // namespace

std::vector<std::string> report_lines(const TargetCalibration& calibration) {
  const StereoEstimate& estimate = calibration.estimate;
  const Validation& validation = calibration.validation;
  const ParameterVector sigmas = estimate.sigmas();
  const Vector6d pose = sigmas.tail<6>();
  const Eigen::Vector3d angles = so3_log(estimate.rig.T_right_left.rotation) * kDegrees;
  const Eigen::Vector3d offset = estimate.rig.T_right_left.inverse().translation;
  return {camera_line("left", estimate.rig.left, sigmas, 0),
          lens_line(estimate.rig.left, sigmas, 0),
          camera_line("right", estimate.rig.right, sigmas, kCameraParameters),
          lens_line(estimate.rig.right, sigmas, kCameraParameters),
          formatted("rotation %.3f +- %.3f, %.3f +- %.3f, %.3f +- %.3f deg about x, y, z", angles.x(),
                    pose(0) * kDegrees, angles.y(), pose(1) * kDegrees, angles.z(), pose(2) * kDegrees),
          formatted("baseline %.5f +- %.5f m (right camera at %.5f, %.5f, %.5f)", offset.norm(), pose(3), offset.x(),
                    offset.y(), offset.z()),
          formatted("corners  %.3f px RMS left, %.3f px right; %zu views, %zu rejected", estimate.left_rms_px,
                    estimate.right_rms_px, estimate.used_views.size(), estimate.rejected_views),
          formatted("checked  on %zu views left out: rows %.3f px RMS (%.2f at most), lengths %+.3f %% (%.3f %% RMS)",
                    validation.views, validation.epipolar_rms_px, validation.epipolar_max_px,
                    100.0 * validation.length_error, 100.0 * validation.length_rms)};
}

std::vector<std::string> remarks(const TargetCalibration& calibration, const ReportSource& source) {
  return {"Made by kinetrace calibrate from " + source.images, "with " + source.target + ", lens model " + source.lens,
          formatted("Corners %.3f px (left), %.3f px (right); rows on views left out %.3f px",
                    calibration.estimate.left_rms_px, calibration.estimate.right_rms_px,
                    calibration.validation.epipolar_rms_px)};
}

std::string report_json(const TargetCalibration& calibration, const ViewCollector& views, const ReportSource& source) {
  const StereoEstimate& estimate = calibration.estimate;
  const Validation& validation = calibration.validation;
  const Json json{{"images", source.images},
                  {"target", source.target},
                  {"lens", source.lens},
                  {"left", camera_json(estimate.rig.left, estimate.left_rms_px)},
                  {"right", camera_json(estimate.rig.right, estimate.right_rms_px)},
                  {"T_right_left", pose_json(estimate.rig.T_right_left)},
                  {"baseline_m", estimate.rig.T_right_left.translation.norm()},
                  {"corner_sigma_px", estimate.sigma_px},
                  {"relative_focal_sigma", estimate.relative_focal_sigma()},
                  {"rotation_sigma_deg", estimate.rotation_sigma_rad() * kDegrees},
                  {"views", views_json(calibration, views)},
                  {"left_out",
                   {{"views", validation.views},
                    {"corners", validation.corners},
                    {"rejected_corners", validation.rejected_corners},
                    {"epipolar_rms_px", validation.epipolar_rms_px},
                    {"epipolar_max_px", validation.epipolar_max_px},
                    {"length_error", validation.length_error},
                    {"length_rms", validation.length_rms}}},
                  {"covariance", covariance_json(estimate.covariance)},
                  {"warnings", calibration.warnings}};
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

Status check_output_folder(const std::filesystem::path& folder) {
  const std::vector<std::filesystem::path> missing = missing_folders(folder);
  Status usable = make_folder(folder);
  if (usable) {
    usable = check_places(folder);
  }
  for (const std::filesystem::path& made : missing) {
    std::error_code not_empty;
    std::filesystem::remove(made, not_empty);
  }
  return usable;
}

Status write_calibration_files(const hal::RigCalibration& rig, const std::filesystem::path& folder,
                               std::span<const std::string> head) {
  Status written = make_folder(folder);
  if (written) {
    written = hal::write_rig_calibration(rig, folder / "calibration.yaml", hal::CalibrationFormat::kOpencv, head);
  }
  if (written && hal::rig_calibration_text(rig, hal::CalibrationFormat::kKalibr)) {
    written = hal::write_rig_calibration(rig, folder / "camchain.yaml", hal::CalibrationFormat::kKalibr, head);
  }
  return written;
}

}  // namespace kinetrace::calibration

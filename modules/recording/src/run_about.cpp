#include "run_about.hpp"

#include <cstdint>
#include <numbers>

#include <nlohmann/json.hpp>

#include "kinetrace/recording/json_text.hpp"

namespace kinetrace::recording {
namespace {

using Json = nlohmann::ordered_json;

/// None for a number with a fraction or an exponent, even if its value is an integer.
std::int64_t whole_number(const Json& json) {
  return json.get_ref<const std::int64_t&>();
}

StereoGeometry geometry_of(const Json& json) {
  return {.fx_px = json.at("fx_px").get<double>(),
          .fy_px = json.at("fy_px").get<double>(),
          .cx_px = json.at("cx_px").get<double>(),
          .cy_px = json.at("cy_px").get<double>(),
          .baseline_m = json.at("baseline_m").get<double>(),
          .width_px = static_cast<int>(whole_number(json.at("width_px"))),
          .height_px = static_cast<int>(whole_number(json.at("height_px")))};
}

RigCorrection correction_of(const Json& json) {
  constexpr double kDegree = std::numbers::pi / 180.0;
  const Json& turn_deg = json.at("turn_deg");
  const Json& baseline_deg = json.at("baseline_deg");
  RigCorrection correction;
  for (std::size_t i = 0; i < 3; ++i) {
    correction.turn_rad[static_cast<Eigen::Index>(i)] = kDegree * turn_deg.at(i).get<double>();
  }
  correction.baseline_rad =
      kDegree * Eigen::Vector2d(baseline_deg.at(0).get<double>(), baseline_deg.at(1).get<double>());
  correction.shift_rad = kDegree * json.at("shift_deg").get<double>();
  correction.focal = 0.01 * json.at("focal_percent").get<double>();
  return correction;
}

RunAbout about_of(const Json& json) {
  RunAbout about;
  const Json& dataset = json.at("dataset");
  about.dataset = dataset.value("dataset", "");
  about.sequence = dataset.value("sequence", "");
  about.cameras = dataset.value("cameras", "");
  about.passes = dataset.value("passes", "");
  for (const auto& [name, value] : dataset.items()) {
    about.dataset_fields.emplace_back(name, value.get<std::string>());
  }
  about.config_json = json.at("config").dump();
  about.frames = whole_number(json.at("frames"));
  if (const auto rectified = json.find("rectified"); rectified != json.end()) {
    about.rectified = geometry_of(*rectified);
  }
  if (const auto calibration = json.find("calibration");
      calibration != json.end() && calibration->contains("applied")) {
    about.applied = correction_of(calibration->at("applied"));
  }
  if (const auto warnings = json.find("warnings"); warnings != json.end()) {
    about.warnings = warnings->get<std::vector<std::string>>();
  }
  if (const auto files = json.find("files"); files != json.end()) {
    for (const Json& file : *files) {
      if (const auto rows = file.find("rows"); rows != file.end()) {
        about.rows.emplace(file.at("path").get<std::string>(), whole_number(*rows));
      }
    }
  }
  return about;
}

}  // namespace

Result<RunAbout> read_run_about(const std::filesystem::path& path) {
  const Result<std::string> text = read_json_text(path);
  if (!text) {
    return Unexpected(text.error());
  }
  try {
    return about_of(Json::parse(*text));
  } catch (const nlohmann::json::exception&) {
    return fail(ErrorCode::kBadFormat,
                path.string() + ": is not the run.json of a run, or was damaged; give the folder of another run");
  }
}

}  // namespace kinetrace::recording

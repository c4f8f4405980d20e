// All metrics of a run against its truth, and their reports.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "kinetrace/evaluation/camera_metrics.hpp"
#include "kinetrace/evaluation/mask_metrics.hpp"
#include "kinetrace/evaluation/object_metrics.hpp"

namespace kinetrace::evaluation {

/// How tracks are matched with true objects.
enum class Association : std::uint8_t { kMasks, kBoxes, kCentres };
[[nodiscard]] std::string_view to_string(Association association) noexcept;

struct Evaluation {
  std::string run;
  std::string truth;
  std::string truth_format;
  std::vector<std::string> notes;  ///< Caveats for the reader of the figures, one line each.
  CameraMetrics camera;
  /// Angle of the constant rotation between the camera's estimated and true frame, see camera_rotation; none if none
  /// was removed.
  std::optional<double> camera_rotation_deg;
  Association association = Association::kMasks;
  ObjectConfig object_config;
  std::optional<ObjectMetrics> objects;
  std::optional<MaskReport> masks;
};

/// The whole evaluation as a JSON object; values that could not be measured are null. Names and units are in the
/// module's README.
[[nodiscard]] std::string evaluation_json(const Evaluation& evaluation);

/// The same as lines of text for people; values that could not be measured are "none".
[[nodiscard]] std::string evaluation_table(const Evaluation& evaluation);

/// The main figures of two runs by the same truth, side by side with their ratios, as lines of text.
[[nodiscard]] std::string comparison_table(const Evaluation& run, const Evaluation& against);

}  // namespace kinetrace::evaluation

// Reads run.json.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "kinetrace/core/result.hpp"
#include "kinetrace/core/rig_correction.hpp"
#include "kinetrace/core/stereo_geometry.hpp"

namespace kinetrace::recording {

struct RunAbout {
  std::string dataset;
  std::vector<std::pair<std::string, std::string>> dataset_fields;  ///< All of it, in order.
  std::string sequence;
  std::string cameras;
  std::string passes;
  std::string config_json;
  std::int64_t frames = 0;
  StereoGeometry rectified;  ///< All zero: unknown.
  RigCorrection applied;
  std::vector<std::string> warnings;
  std::map<std::string, std::int64_t> rows;  ///< By file; unknown for files not listed.
};

/// Errors: those of read_json_text; kBadFormat (not a run.json of a run).
[[nodiscard]] Result<RunAbout> read_run_about(const std::filesystem::path& path);

}  // namespace kinetrace::recording

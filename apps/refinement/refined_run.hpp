// Writes a refined run as a run folder.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "camera_refinement.hpp"
#include "kinetrace/recording/run_summary.hpp"
#include "object_refinement.hpp"
#include "path_graph.hpp"

namespace kinetrace::batch {

struct RefinedRun {
  RefinedCamera camera;
  std::map<std::uint32_t, RefinedObject> objects;           ///< By track.
  std::map<std::uint32_t, std::uint32_t> joined_into = {};  ///< New ids of tracks joined to another one.
  PathCorrection path = {};
  MeasuredBackground measured = {};
  std::vector<std::string> notes = {};  ///< Steps that failed, one line each.
};

/// Writes all files of the run's folder, except images/, with refined values. `summary` is completed with the results.
/// `progress` gets the number of rows written. Errors: those of RunRecorder, and of the files read again.
[[nodiscard]] Status write_refined_run(const recording::Run& run, const RefinedRun& refined,
                                       const std::filesystem::path& directory, recording::RunSummary summary,
                                       const std::function<void(std::size_t)>& progress);

}  // namespace kinetrace::batch

// Plays a recording through the whole chain like an application, and keeps the results for tests.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "kinetrace/core/frame_result.hpp"
#include "kinetrace/hal/dataset.hpp"
#include "kinetrace/pipeline/config.hpp"

namespace kinetrace::test {

/// Folder of the recordings: KINETRACE_DATA, by default ../shared/data beside the source tree. Empty if there is none.
[[nodiscard]] std::optional<std::filesystem::path> data_folder();

/// One finalised row of one object.
struct ObjectRow {
  std::int64_t frame = 0;
  ObjectResult object;
  Se3 T_world_cam;
};

struct ClipRun {
  std::vector<std::int64_t> frames;
  std::vector<CameraResult> camera;                         ///< Finalised, one per frame.
  std::map<std::uint32_t, std::vector<ObjectRow>> objects;  ///< Finalised rows by track id, in order of time.
  FrameCounters counters;
};

/// Runs the whole clip. Fails the current test and returns the results so far on any error.
[[nodiscard]] ClipRun run_clip(const hal::DatasetSpec& spec, pipeline::PipelineConfig config);

/// Distance of an object from the camera of its frame.
[[nodiscard]] double distance_m(const ObjectRow& row);

/// Poses in KITTI's format: 12 numbers a line, row-major 3 x 4.
[[nodiscard]] std::vector<Se3> read_kitti_poses(const std::filesystem::path& path);

/// Frames by which `truth` lags behind `estimate`, in [-1, 1], from rotation rates alone, which no error of scale
/// affects. The recorded truth was aligned with the images' times by a fit of its own.
[[nodiscard]] double time_offset_frames(const std::vector<Se3>& truth, const std::vector<Se3>& estimate);

/// The path at fractional frames i + `offset_frames`, clamped to its ends.
[[nodiscard]] std::vector<Se3> shifted(const std::vector<Se3>& path, double offset_frames);

/// Mean translation error per distance over all sub-paths of `length_m`, relative (KITTI's t_rel for one length).
[[nodiscard]] double translation_drift(const std::vector<Se3>& truth, const std::vector<Se3>& estimate,
                                       double length_m);

/// Mean relative error of the distance covered over all sub-paths of `length_m`, whatever its direction.
[[nodiscard]] double length_error(const std::vector<Se3>& truth, const std::vector<Se3>& estimate, double length_m);

}  // namespace kinetrace::test

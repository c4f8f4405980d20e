// One reader for each file format of ground truth.
#pragma once

#include <filesystem>

#include "kinetrace/evaluation/truth.hpp"

namespace kinetrace::evaluation {

/// 12 numbers a line; the key is the number of the line, from 0.
[[nodiscard]] Result<TrueCamera> read_kitti_poses(const std::filesystem::path& path);
[[nodiscard]] Result<TrueCamera> read_tum(const std::filesystem::path& path);
[[nodiscard]] Result<TrueCamera> read_euroc(const std::filesystem::path& path, const Se3& T_body_cam);

using ObjectsByFrame = std::map<std::int64_t, std::vector<LocatedObject>>;

/// The simulator's objects.csv, visible objects only.
[[nodiscard]] Result<ObjectsByFrame> read_simulator_objects(const std::filesystem::path& path);

/// KITTI tracking labels; poses are transformed into the world by `camera`, frames without a camera pose are left out.
/// Velocities come from the positions two frames before and after.
[[nodiscard]] Result<ObjectsByFrame> read_kitti_labels(const std::filesystem::path& path, const TrueCamera& camera,
                                                       const TruthSource& source);

}  // namespace kinetrace::evaluation

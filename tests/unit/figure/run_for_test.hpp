// Small runs: in memory, and as folders.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "figure/figure_run.hpp"
#include "kinetrace/recording/run_reader.hpp"

namespace kinetrace::figure {

inline constexpr std::int64_t kPeriod_ns = 100'000'000;
inline constexpr int kImageWidth = 320;
inline constexpr int kImageHeight = 160;

/// The camera drives along z, a metre a frame.
[[nodiscard]] recording::Run straight_drive(int frames);

/// A tracked object of 4 x 1.5 x 2 m at the given place, 40 px tall in the middle of the picture.
[[nodiscard]] recording::ObjectRow object_row(std::int64_t frame, std::uint32_t track_id,
                                              const Eigen::Vector3d& position_m);

/// Ten frames. Car 1 drives ahead of the camera at its speed, tracked; car 2 stands; pedestrian 3 is tracked by stereo
/// only until it is lost in frame 5.
[[nodiscard]] recording::Run small_street();

[[nodiscard]] FigureRun open(recording::Run run);

/// Writes a run folder with these rows as `kinetrace run` would: run.json, poses, objects, and for every row that is
/// not lost a rectangular mask (its mask_px).
void write_run(const recording::Run& run, const std::filesystem::path& directory, const std::string& dataset);

/// Writes a cloud of points on a grid of the given spacing about the origin, as in a run folder.
void write_cloud(const std::filesystem::path& path, int points_per_side, double spacing_m);

/// Writes a rectified recording (KITTI odometry layout) with so many gray frames; returns "LAYOUT:PATH".
[[nodiscard]] std::string write_recording(const std::filesystem::path& directory, int frames);

}  // namespace kinetrace::figure

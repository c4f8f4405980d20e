// A run as a film: the frame with its results, above the trajectories so far.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

#include "drawing/canvas.hpp"
#include "figure/figure_images.hpp"
#include "figure/figure_points.hpp"
#include "figure/figure_run.hpp"
#include "figure/figure_scene.hpp"
#include "kinetrace/recording/mask_frames.hpp"

namespace kinetrace::figure {

/// Width of a film's pictures: the usual width on a page, so that names stay legible. The image is scaled to it.
inline constexpr int kFilmWidth_px = 720;

/// One picture of the film. The view from above always covers the whole run, so that only the paths grow. `background`:
/// its points.
[[nodiscard]] drawing::Canvas draw_film_frame(const FigureRun& run, const Cloud& background, std::int64_t frame,
                                              GrayView image, const StereoGeometry& geometry,
                                              const std::vector<TrackMask>& masks);

/// Writes the pictures of all frames. Errors: those of write_overlay and background_of.
[[nodiscard]] Result<std::int64_t> write_film(const FigureRun& run, RecordedImages& images,
                                              recording::MaskFrames& masks, const std::filesystem::path& directory,
                                              const std::function<bool(std::int64_t, int)>& progress);

}  // namespace kinetrace::figure

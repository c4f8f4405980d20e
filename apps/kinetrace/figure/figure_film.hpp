// A run as a film: the frame with everything that was found drawn into it, above the trajectories so far.
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

/// Width of a film's pictures: as wide as pages show them, so that names can be read. The image is scaled to it.
inline constexpr int kFilmWidth_px = 720;

/// One picture of the film. The view from above covers the whole run in every frame, so that only the paths grow.
/// `background` gives its backdrop.
[[nodiscard]] drawing::Canvas draw_film_frame(const FigureRun& run, const Cloud& background, std::int64_t frame,
                                              GrayView image, const StereoGeometry& geometry,
                                              const std::vector<TrackMask>& masks);

/// Writes them as write_overlay does. Errors: its own, and those of background_of.
[[nodiscard]] Result<std::int64_t> write_film(const FigureRun& run, RecordedImages& images,
                                              recording::MaskFrames& masks, const std::filesystem::path& directory,
                                              const std::function<bool(std::int64_t, int)>& progress);

}  // namespace kinetrace::figure

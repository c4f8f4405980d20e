// The result figure of the method, as one page.
#pragma once

#include "drawing/canvas.hpp"
#include "figure/figure_scene.hpp"

namespace kinetrace::figure {

inline constexpr int kPageWidth_px = 1600;

/// Input frame, object and background segmentation, table of objects, object and background reconstruction, and the
/// trajectories from above and from the side (after the result figure of Bullinger et al., "Stereo 3D Object Trajectory
/// Reconstruction", AVSS 2018). The height follows from the shape of the images and of the paths.
[[nodiscard]] drawing::Canvas draw_page(const Scene& scene);

}  // namespace kinetrace::figure

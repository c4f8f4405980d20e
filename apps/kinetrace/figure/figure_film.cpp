#include "figure/figure_film.hpp"

#include <cmath>

#include "drawing/axes.hpp"
#include "figure/figure_overlay.hpp"
#include "figure/figure_panels.hpp"

namespace kinetrace::figure {
namespace {

constexpr double kGap_px = 12.0;
constexpr double kPlan_px = 272.0;  ///< With the axes' numbers and labels.

}  // namespace

drawing::Canvas draw_film_frame(const FigureRun& run, const Cloud& background, std::int64_t frame, GrayView image,
                                const StereoGeometry& geometry, const std::vector<TrackMask>& masks) {
  Scene scene;
  scene.run = &run;
  scene.frame = frame;
  scene.geometry = geometry;
  scene.background = background;
  const double image_px = std::round(static_cast<double>(kFilmWidth_px) * image.height / image.width);
  const drawing::Rect plan{0.0, image_px + kGap_px, kFilmWidth_px - kGap_px, kPlan_px};
  drawing::Canvas canvas(kFilmWidth_px, static_cast<int>(plan.bottom()), drawing::kPaper);
  draw_overlay(canvas, {0.0, 0.0, kFilmWidth_px, image_px}, run, frame, image, geometry, masks);
  draw_trajectories_so_far(canvas, drawing::inside_margins(plan), scene);
  return canvas;
}

Result<std::int64_t> write_film(const FigureRun& run, RecordedImages& images, recording::MaskFrames& masks,
                                const std::filesystem::path& directory,
                                const std::function<bool(std::int64_t, int)>& progress) {
  const Result<Cloud> background = background_of(run.run());
  if (!background) {
    return Unexpected(background.error());
  }
  const auto draw = [&](std::int64_t frame, GrayView image, const std::vector<TrackMask>& parts) {
    return draw_film_frame(run, *background, frame, image, images.geometry(), parts);
  };
  return write_frames(run, images, masks, directory, draw, progress);
}

}  // namespace kinetrace::figure

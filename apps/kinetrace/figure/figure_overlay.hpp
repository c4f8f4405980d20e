// The recording with everything that was found drawn into it, one picture a frame.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>

#include "drawing/canvas.hpp"
#include "figure/figure_images.hpp"
#include "figure/figure_run.hpp"
#include "figure/figure_scene.hpp"
#include "kinetrace/recording/mask_frames.hpp"

namespace kinetrace::figure {

/// Past positions of a moving object that its trail shows.
inline constexpr std::size_t kTrailFrames = 60;

/// Tinted masks; for each object its name, speed and distance; for tracked ones the box; the way a moving object came.
[[nodiscard]] drawing::Canvas draw_overlay(const FigureRun& run, std::int64_t frame, GrayView image,
                                           const StereoGeometry& geometry, const std::vector<TrackMask>& masks);
/// The same within an area of the image's shape.
void draw_overlay(drawing::Canvas& canvas, const drawing::Rect& area, const FigureRun& run, std::int64_t frame,
                  GrayView image, const StereoGeometry& geometry, const std::vector<TrackMask>& masks);

/// Draws one frame, given its number, image and masks.
using FrameDrawing = std::function<drawing::Canvas(std::int64_t, GrayView, const std::vector<TrackMask>&)>;

/// Writes DIR/STEM.png for every frame of the run whose image the recording has; earlier pictures of these names are
/// replaced, nothing else is. `progress` is called after each frame with the number done and the objects in it; when it
/// returns false, writing ends early. Returns the number of pictures. Errors: kIo, kInvalidArgument (something else is
/// in the place of a picture), and those of images and masks.
[[nodiscard]] Result<std::int64_t> write_overlay(const FigureRun& run, RecordedImages& images,
                                                 recording::MaskFrames& masks, const std::filesystem::path& directory,
                                                 const std::function<bool(std::int64_t, int)>& progress);
/// The same with other pictures of the frames.
[[nodiscard]] Result<std::int64_t> write_frames(const FigureRun& run, RecordedImages& images,
                                                recording::MaskFrames& masks, const std::filesystem::path& directory,
                                                const FrameDrawing& draw,
                                                const std::function<bool(std::int64_t, int)>& progress);

}  // namespace kinetrace::figure

// The recording with the results drawn into it, one picture a frame.
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

/// Past positions in a moving object's trail.
inline constexpr std::size_t kTrailFrames = 60;

/// Tinted masks; for each object its name, speed and distance; boxes of tracked objects; trails of moving objects.
[[nodiscard]] drawing::Canvas draw_overlay(const FigureRun& run, std::int64_t frame, GrayView image,
                                           const StereoGeometry& geometry, const std::vector<TrackMask>& masks);
/// The same, scaled to an area of the image's shape.
void draw_overlay(drawing::Canvas& canvas, const drawing::Rect& area, const FigureRun& run, std::int64_t frame,
                  GrayView image, const StereoGeometry& geometry, const std::vector<TrackMask>& masks);

/// Draws one frame, given its number, image and masks.
using FrameDrawing = std::function<drawing::Canvas(std::int64_t, GrayView, const std::vector<TrackMask>&)>;

/// Writes DIR/STEM.png for every frame of the run with an image in the recording. Replaces earlier pictures of these
/// names and nothing else. `progress` is called after each frame with the number done and the objects in it; if it
/// returns false, writing ends early. Returns the number of pictures. Errors: kIo, kInvalidArgument (another file at a
/// picture's path), and those of images and masks.
[[nodiscard]] Result<std::int64_t> write_overlay(const FigureRun& run, RecordedImages& images,
                                                 recording::MaskFrames& masks, const std::filesystem::path& directory,
                                                 const std::function<bool(std::int64_t, int)>& progress);
/// The same with another drawing function.
[[nodiscard]] Result<std::int64_t> write_frames(const FigureRun& run, RecordedImages& images,
                                                recording::MaskFrames& masks, const std::filesystem::path& directory,
                                                const FrameDrawing& draw,
                                                const std::function<bool(std::int64_t, int)>& progress);

}  // namespace kinetrace::figure

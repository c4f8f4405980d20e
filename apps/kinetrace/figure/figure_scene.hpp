// The data of one figure.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "figure/figure_images.hpp"
#include "figure/figure_points.hpp"
#include "figure/figure_run.hpp"
#include "kinetrace/core/image_view.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/core/stereo_geometry.hpp"
#include "kinetrace/recording/mask_frames.hpp"

namespace kinetrace::figure {

/// A track's area in the frame.
struct TrackMask {
  std::uint32_t track_id = 0;
  std::uint16_t class_id = 0;
  PixelBox box_px;
  std::vector<std::uint8_t> pixels;  ///< Of the whole image: 255 inside, 0 outside.
};

struct Scene {
  const FigureRun* run = nullptr;
  std::int64_t frame = 0;
  std::optional<std::uint32_t> object;  ///< The object with its reconstruction shown.
  StereoGeometry geometry;              ///< Of the rectified left camera.
  std::vector<std::uint8_t> image;      ///< geometry.width_px x geometry.height_px; empty if there is none.
  std::string image_problem;            ///< Why there is none.
  std::vector<TrackMask> masks;
  Cloud background;
  Cloud object_model;  ///< In the object's frame.

  [[nodiscard]] GrayView image_view() const noexcept {
    return {image.data(), geometry.width_px, geometry.height_px, geometry.width_px};
  }
  [[nodiscard]] GrayView mask_view(const TrackMask& mask) const noexcept {
    return {mask.pixels.data(), geometry.width_px, geometry.height_px, geometry.width_px};
  }
};

/// The user's choice.
struct SceneChoice {
  std::optional<std::int64_t> frame;
  std::optional<std::uint32_t> object;
};

/// Loads the data from the run folder. `images` is null if the recording cannot be opened; `image_problem` then has the
/// reason. `run` must outlive the scene. Errors: kInvalidArgument (no such frame or track; lists the existing ones),
/// and those of damaged files of the run folder. Missing optional files (masks, points) leave their parts empty.
[[nodiscard]] Result<Scene> make_scene(const FigureRun& run, const SceneChoice& choice, RecordedImages* images,
                                       const std::string& image_problem, recording::MaskFrames& masks);

/// The run's rectified left camera; if unknown, a camera of 90 degrees with the size of the masks, or 2:1.
[[nodiscard]] StereoGeometry recorded_geometry(const recording::Run& run, LabelView labels);

/// The background's points; none if the run has not written them. Errors: those of read_cloud.
[[nodiscard]] Result<Cloud> background_of(const recording::Run& run);

/// The masks of a frame one by one.
[[nodiscard]] std::vector<TrackMask> separate(const recording::MaskFrame& frame);

}  // namespace kinetrace::figure

// The panels of a figure; each fills its rectangle.
#pragma once

#include <string>

#include "drawing/canvas.hpp"
#include "figure/figure_scene.hpp"

namespace kinetrace::figure {

/// The frame as it was recorded (rectified, left).
void draw_input(drawing::Canvas& canvas, const drawing::Rect& area, const Scene& scene);
/// The faded frame with tinted, named tracks. Without masks: the boxes of objects.csv, or "no objects".
void draw_object_segmentation(drawing::Canvas& canvas, const drawing::Rect& area, const Scene& scene);
/// The frame without the pixels of tracks.
void draw_background_segmentation(drawing::Canvas& canvas, const drawing::Rect& area, const Scene& scene);
/// The frame's objects as a table: colour, name, speed, distance, height, status. The tallest first, as space permits.
void draw_object_table(drawing::Canvas& canvas, const drawing::Rect& area, const Scene& scene);

/// The chosen object's points and box from its cameras' direction; beside it the cameras from above, in metres.
void draw_object_reconstruction(drawing::Canvas& canvas, const drawing::Rect& area, const Scene& scene);
/// The background's points with the path of the camera, from behind and above the camera.
void draw_background_reconstruction(drawing::Canvas& canvas, const drawing::Rect& area, const Scene& scene);

/// Camera and objects from above (x-z) and from the side (z-y). Views placed one above the other share the horizontal
/// axis.
struct TrajectoryAreas {
  drawing::Rect top;
  drawing::Rect side;
  bool stacked = true;
};
/// Ratio of the paths' extents along z and x in the view from above.
[[nodiscard]] double path_elongation(const Scene& scene);
/// Returns a note on omissions and changes of scale, for the caption; empty if there are none.
std::string draw_trajectories(drawing::Canvas& canvas, const TrajectoryAreas& areas, const Scene& scene);
/// The view from above with the paths up to the scene's frame. It covers the whole run, z to the right.
void draw_trajectories_so_far(drawing::Canvas& canvas, const drawing::Rect& area, const Scene& scene);

/// A scale bar of a round number of metres, with its length, ending at `right_end`.
void draw_scale_bar(drawing::Canvas& canvas, const drawing::Point& right_end, double pixels_per_metre,
                    double longest_px);

/// Label of an object in an image: name, speed if it moves, distance from the camera.
[[nodiscard]] std::string object_label(const recording::ObjectRow& object, const Se3& T_world_cam);

}  // namespace kinetrace::figure

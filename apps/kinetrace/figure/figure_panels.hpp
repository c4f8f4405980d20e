// The parts of a figure; each fills the rectangle it is given.
#pragma once

#include <string>

#include "drawing/canvas.hpp"
#include "figure/figure_scene.hpp"

namespace kinetrace::figure {

/// The frame as it was recorded (rectified, left).
void draw_input(drawing::Canvas& canvas, const drawing::Rect& area, const Scene& scene);
/// The faded frame with a tint over each track, named. Without masks: the boxes of objects.csv, or "no objects".
void draw_object_segmentation(drawing::Canvas& canvas, const drawing::Rect& area, const Scene& scene);
/// The frame without what belongs to tracks.
void draw_background_segmentation(drawing::Canvas& canvas, const drawing::Rect& area, const Scene& scene);
/// The frame's objects as a table: colour, name, speed, distance, height, status. As many as there is room for, the
/// tallest first.
void draw_object_table(drawing::Canvas& canvas, const drawing::Rect& area, const Scene& scene);

/// The points of the chosen object and its box as its cameras saw it; beside that, from above and in metres, the
/// cameras.
void draw_object_reconstruction(drawing::Canvas& canvas, const drawing::Rect& area, const Scene& scene);
/// The background's points with the path of the camera, from behind and above the camera.
void draw_background_reconstruction(drawing::Canvas& canvas, const drawing::Rect& area, const Scene& scene);

/// Camera and objects from above (x-z) and from the side (z-y). Both get the same horizontal axis where they stand one
/// above the other.
struct TrajectoryAreas {
  drawing::Rect top;
  drawing::Rect side;
  bool stacked = true;
};
/// How much longer the paths are along z than along x, as the view from above would show them.
[[nodiscard]] double path_elongation(const Scene& scene);
/// Returns what the views had to leave out or change, to be said beside them; empty if nothing.
std::string draw_trajectories(drawing::Canvas& canvas, const TrajectoryAreas& areas, const Scene& scene);
/// The view from above with the paths up to the scene's frame. What it covers is that of the whole run, z to the right.
void draw_trajectories_so_far(drawing::Canvas& canvas, const drawing::Rect& area, const Scene& scene);

/// A scale bar of a round number of metres, with its length, ending at `right_end`.
void draw_scale_bar(drawing::Canvas& canvas, const drawing::Point& right_end, double pixels_per_metre,
                    double longest_px);

/// What a label in an image says of an object: name, speed if it moves, distance from the camera.
[[nodiscard]] std::string object_label(const recording::ObjectRow& object, const Se3& T_world_cam);

}  // namespace kinetrace::figure

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>

#include "drawing/label_placer.hpp"
#include "figure/figure_panels.hpp"
#include "figure/figure_plan.hpp"
#include "figure/figure_views.hpp"

namespace kinetrace::figure {
namespace {

using drawing::Canvas;
using drawing::Color;
using drawing::Point;
using drawing::Range;
using drawing::Rect;

constexpr std::size_t kPathPoints = 3000;
constexpr std::size_t kLabels = 24;
constexpr double kMaxStretch = 50.0;
constexpr std::size_t kBackgroundPoints = 15'000;
constexpr double kMin_m = 2.0;  ///< The smallest extent that is shown.
constexpr double kLabelSize_px = 8.5;

/// One track's path in the world: that of the body's point at the centre of its last tracked box.
struct Path {
  const TrackRows* track = nullptr;
  Line3 points;                           ///< Not finite where the track was lost.
  std::vector<Eigen::Vector3d> reliable;  ///< The tracked ones.
};

struct Paths {
  Line3 camera;
  std::vector<Path> objects;  ///< Those of the scene's frame first, then those with most rows.
  std::size_t longest_step = 1;
};

/// In the object's frame.
Eigen::Vector3d middle_of(const TrackRows& track) {
  const auto last = std::find_if(track.rows.rbegin(), track.rows.rend(),
                                 [](const auto* row) { return row->status == BodyStatus::kTracked; });
  const recording::ObjectRow& row = last == track.rows.rend() ? *track.rows.back() : **last;
  return row.T_world_obj.inverse() * row.box.center_m;
}

Path path_of(const TrackRows& track, std::int64_t last, std::size_t& longest_step) {
  const std::size_t step = every_nth(track.rows.size(), kPathPoints);
  longest_step = std::max(longest_step, step);
  Path path{&track, {}, {}};
  const Eigen::Vector3d middle = middle_of(track);
  std::int64_t last_frame = track.rows.front()->frame;
  for (std::size_t i = 0; i < track.rows.size() && track.rows[i]->frame <= last; i += step) {
    const recording::ObjectRow& row = *track.rows[i];
    const bool is_lost = row.status == BodyStatus::kLost;
    const bool has_gap = is_lost || row.frame - last_frame > static_cast<std::int64_t>(2 * step);
    if (has_gap && !path.points.empty()) {
      path.points.emplace_back(Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()));
    }
    if (!is_lost) {
      path.points.push_back(row.T_world_obj * middle);
      last_frame = row.frame;
    }
    if (row.status == BodyStatus::kTracked) {
      path.reliable.push_back(path.points.back());
    }
  }
  return path;
}

bool is_in(const TrackRows& track, std::int64_t frame) {
  return track.rows.front()->frame <= frame && frame <= track.rows.back()->frame;
}

/// The paths up to the frame `last`.
Paths paths_of(const Scene& scene, std::int64_t last) {
  Paths paths;
  const auto& camera = scene.run->run().camera;
  paths.longest_step = every_nth(camera.size(), kPathPoints);
  for (std::size_t i = 0; i < camera.size() && camera[i].frame <= last; i += paths.longest_step) {
    paths.camera.push_back(camera[i].T_world_cam.translation);
  }
  for (const TrackRows& track : scene.run->tracks()) {
    paths.objects.push_back(path_of(track, last, paths.longest_step));
  }
  std::stable_sort(paths.objects.begin(), paths.objects.end(), [&](const Path& a, const Path& b) {
    const bool a_is_here = is_in(*a.track, scene.frame);
    const bool b_is_here = is_in(*b.track, scene.frame);
    return a_is_here != b_is_here ? a_is_here : a.track->rows.size() > b.track->rows.size();
  });
  return paths;
}

Paths paths_of(const Scene& scene) {
  return paths_of(scene, scene.run->last_frame());
}

/// Range of a view along one axis: the paths of camera and moving objects without outliers, and most static objects.
/// Only tracked positions of objects count, unless there are none.
Range range_along(const Paths& paths, Eigen::Index axis) {
  std::array<std::vector<double>, 3> values;  // Camera, moving, static.
  for (const Eigen::Vector3d& p : paths.camera) {
    values[0].push_back(p[axis]);
  }
  const bool has_reliable =
      std::any_of(paths.objects.begin(), paths.objects.end(), [](const Path& path) { return !path.reliable.empty(); });
  for (const Path& path : paths.objects) {
    for (const Eigen::Vector3d& p : has_reliable ? path.reliable : path.points) {
      values[path.track->moving ? 1 : 2].push_back(p[axis]);
    }
  }
  constexpr std::array<double, 3> kWild{0.002, 0.01, 0.08};
  Range range{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (std::size_t kind = 0; kind < values.size(); ++kind) {
    if (const auto part = drawing::quantile_range(values[kind], kWild[kind])) {
      range = {std::min(range.low, part->low), std::max(range.high, part->high)};
    }
  }
  return range.low <= range.high ? range : Range{-1.0, 1.0};
}

using Projection = std::function<Point(const Eigen::Vector3d&)>;

Line2 projected(const Line3& line, const Projection& to_canvas) {
  Line2 image;
  for (const Eigen::Vector3d& p : line) {
    image.push_back(p.allFinite() ? to_canvas(p) : Point::Constant(std::numeric_limits<double>::quiet_NaN()));
  }
  return image;
}

Point last_finite(const Line2& line) {
  const auto last = std::find_if(line.rbegin(), line.rend(), [](const Point& p) { return p.allFinite(); });
  return last == line.rend() ? Point::Constant(std::numeric_limits<double>::quiet_NaN()) : *last;
}

Point last_within(const Line2& line, const Rect& area) {
  const auto last = std::find_if(line.rbegin(), line.rend(), [&](const Point& p) { return area.contains(p); });
  return last == line.rend() ? Point::Constant(std::numeric_limits<double>::quiet_NaN()) : *last;
}

/// An arrow head at the end of a path, in the direction of its last pixels.
void draw_head(Canvas& canvas, const Line2& line, Color color) {
  const Point tip = last_finite(line);
  constexpr double kBack_px = 9.0;
  const auto behind =
      std::find_if(line.rbegin(), line.rend(), [&](const Point& p) { return (p - tip).norm() > kBack_px; });
  if (!tip.allFinite() || behind == line.rend()) {
    return;
  }
  const Point along = (tip - *behind).normalized();
  const Point across(-along.y(), along.x());
  const std::array<Point, 3> corners{tip + along * 4.0, tip - along * 6.0 + across * 4.5,
                                     tip - along * 6.0 - across * 4.5};
  canvas.polygon(corners, color);
}

void draw_background(Canvas& canvas, const Scene& scene, const Projection& to_canvas) {
  const auto& points = scene.background.points;
  const std::size_t step = every_nth(points.size(), kBackgroundPoints);
  constexpr std::size_t kFew = 4000;
  const double radius_px = points.size() < kFew ? 1.0 : 0.8;
  for (std::size_t i = 0; i < points.size(); i += step) {
    canvas.disk(to_canvas(points[i].position_m.cast<double>()), radius_px, drawing::kMuted, 0.34);
  }
}

void draw_static(Canvas& canvas, const Path& path, const Line2& line) {
  const drawing::LineStyle style = drawing::track_style(path.track->track_id);
  canvas.polyline(line, {.color = style.color, .width_px = 1.0, .alpha = 0.35});
  canvas.disk(last_finite(line), 3.0, style.color, 0.45);
}

void draw_moving(Canvas& canvas, const Path& path, const Line2& line) {
  const drawing::LineStyle style = drawing::track_style(path.track->track_id);
  canvas.polyline(line, {.color = drawing::kPanel, .width_px = 4.5, .alpha = 0.7});
  canvas.polyline(line, {.color = style.color, .width_px = 2.4, .dash = style.dash});
  draw_head(canvas, line, style.color);
}

void draw_label(Canvas& canvas, drawing::LabelPlacer& placer, const Point& anchor, const std::string& text, Color color,
                double size_px) {
  const drawing::TextStyle style{.size_px = size_px,
                                 .color = color,
                                 .horizontal = drawing::HorizontalAnchor::kCenter,
                                 .vertical = drawing::VerticalAnchor::kMiddle,
                                 .halo_px = 2.0,
                                 .halo = drawing::kPanel};
  if (const auto place = placer.place(anchor, text_width(text, style) + 4.0, size_px + 6.0, 7.0)) {
    canvas.text(place->center(), text, style);
  }
}

/// Contents of one view, with labels that avoid each other and the scale bar.
void draw_world(Canvas& canvas, const Rect& area, const Scene& scene, const Paths& paths, const Projection& to_canvas,
                const Rect& kept_free, bool name_static) {
  canvas.clip(area);
  draw_background(canvas, scene, to_canvas);
  const Line2 camera = projected(paths.camera, to_canvas);
  std::vector<std::pair<const Path*, Line2>> lines;
  for (const Path& path : paths.objects) {
    lines.emplace_back(&path, projected(path.points, to_canvas));
  }
  for (const bool moving : {false, true}) {
    for (const auto& [path, line] : lines) {
      if (path->track->moving == moving) {
        moving ? draw_moving(canvas, *path, line) : draw_static(canvas, *path, line);
      }
    }
  }
  canvas.polyline(camera, {.color = drawing::kPanel, .width_px = 5.0, .alpha = 0.7});
  canvas.polyline(camera, {.color = drawing::kInk, .width_px = 2.6});
  draw_head(canvas, camera, drawing::kInk);
  canvas.disk(last_finite(camera), 2.5, drawing::kInk);
  canvas.unclip();

  drawing::LabelPlacer placer(area.grown(-3.0));
  placer.block(kept_free);
  placer.avoid(camera);
  for (const auto& [path, line] : lines) {
    if (path->track->moving) {
      placer.avoid(line);
    }
  }
  draw_label(canvas, placer, last_within(camera, area), "camera", drawing::kInk, kLabelSize_px);
  std::size_t labels = 0;
  for (const bool moving : {true, false}) {
    for (const auto& [path, line] : lines) {
      const Point anchor = last_within(line, area);
      if (path->track->moving != moving || !(moving || name_static) || !anchor.allFinite() || labels == kLabels) {
        continue;
      }
      ++labels;
      const Color color = drawing::mix(drawing::track_style(path->track->track_id).color, drawing::kInk, 0.35);
      const std::string name =
          moving ? track_name(path->track->class_id, path->track->track_id) : std::to_string(path->track->track_id);
      draw_label(canvas, placer, anchor, name, color, moving ? kLabelSize_px : 7.0);
    }
  }
}

/// Camera and objects in the scene's frame.
void draw_now(Canvas& canvas, const PlanView& plan, const Scene& scene) {
  canvas.clip(plan.area());
  for (const recording::ObjectRow& object : scene.run->objects_at(scene.frame)) {
    if (object.status != BodyStatus::kLost) {
      const auto corners = object.box.corners();
      Line2 footprint =
          line_on_canvas(plan, Line3{corners[2], corners[3], corners[7], corners[6]});  // Round the bottom.
      const Color color = drawing::track_style(object.track_id).color;
      canvas.polygon(footprint, color, object.moving ? 0.35 : 0.15);
      footprint.push_back(footprint.front());
      canvas.polyline(footprint, {.color = color, .width_px = 1.2, .alpha = object.moving ? 1.0 : 0.5});
    }
  }
  constexpr double kWedge_px = 26.0;
  const Line2 wedge = line_on_canvas(plan, camera_wedge(scene.run->camera_at(scene.frame)->T_world_cam, scene.geometry,
                                                        kWedge_px / plan.pixels_per_metre()));
  canvas.polygon(wedge, drawing::kInk, 0.2);
  canvas.polyline(wedge, {.color = drawing::kInk, .width_px = 1.3});
  canvas.unclip();
}

Rect bar_place(const Rect& area) {
  return {area.right() - 0.2 * area.width - 24.0, area.bottom() - 38.0, 0.2 * area.width + 24.0, 38.0};
}

void draw_bar(Canvas& canvas, const Rect& area, double pixels_per_metre) {
  draw_scale_bar(canvas, {area.right() - 16.0, area.bottom() - 14.0}, pixels_per_metre, 0.2 * area.width);
}

/// `range`, extended by the frame's boxes near it.
Range with_boxes(const Range& range, const Scene& scene, Eigen::Index axis) {
  constexpr double kNear = 0.35;
  const Range limit = range.widened(kNear);
  Range result = range;
  for (const recording::ObjectRow& object : scene.run->objects_at(scene.frame)) {
    if (object.status != BodyStatus::kTracked) {
      continue;
    }
    for (const Eigen::Vector3d& corner : object.box.corners()) {
      result.low = std::min(result.low, std::max(corner[axis], limit.low));
      result.high = std::max(result.high, std::min(corner[axis], limit.high));
    }
  }
  return result;
}

Range shown_x(const Scene& scene, const Paths& paths) {
  return with_boxes(range_along(paths, 0).at_least(kMin_m), scene, 0).widened(0.1);
}
Range shown_z(const Scene& scene, const Paths& paths) {
  return with_boxes(range_along(paths, 2).at_least(kMin_m), scene, 2).widened(0.04);
}

void draw_plan(Canvas& canvas, const PlanView& plan, const Scene& scene, const Paths& paths) {
  const Rect& area = plan.area();
  plan.draw_axes(canvas);
  draw_now(canvas, plan, scene);
  draw_world(
      canvas, area, scene, paths, [&](const Eigen::Vector3d& p) { return plan.to_canvas(p); }, bar_place(area), true);
  draw_bar(canvas, area, plan.pixels_per_metre());
}

PlanView draw_top(Canvas& canvas, const Rect& area, const Scene& scene, const Paths& paths, bool stacked) {
  const Range x = shown_x(scene, paths);
  const Range z = shown_z(scene, paths);
  PlanView plan = stacked ? PlanView::lying(area, x, z) : PlanView(area, x, z);
  draw_plan(canvas, plan, scene, paths);
  return plan;
}

/// Returns the stretch factor of heights.
double draw_side(Canvas& canvas, const Rect& area, const Scene& scene, const Paths& paths, Range z, bool stacked) {
  const Range y = range_along(paths, 1).at_least(kMin_m / 2).widened(0.2);
  if (!stacked) {
    z = z.at_least(y.size() * area.width / area.height);
  }
  const double pixels_per_metre = area.width / z.size();
  // Heights change little beside distances: they are stretched by a round number.
  const double stretch = std::min(kMaxStretch, drawing::round_below(area.height / y.size() / pixels_per_metre));
  const Range shown = y.at_least(area.height / (pixels_per_metre * stretch));
  const drawing::Axes axes(area, {.label = "z forward [m]", .range = z},
                           {.label = "y down [m]", .range = shown, .reversed = true});
  axes.draw(canvas);
  draw_world(
      canvas, area, scene, paths, [&](const Eigen::Vector3d& p) { return axes.to_canvas(p.z(), p.y()); },
      bar_place(area), false);
  draw_bar(canvas, area, pixels_per_metre);
  return stretch;
}

}  // namespace

double path_elongation(const Scene& scene) {
  const Paths paths = paths_of(scene);
  return shown_z(scene, paths).size() / shown_x(scene, paths).size();
}

std::string draw_trajectories(Canvas& canvas, const TrajectoryAreas& areas, const Scene& scene) {
  const Paths paths = paths_of(scene);
  const PlanView plan = draw_top(canvas, areas.top, scene, paths, areas.stacked);
  const Range z = areas.stacked ? plan.z_range() : shown_z(scene, paths);
  const double stretch = draw_side(canvas, areas.side, scene, paths, z, areas.stacked);
  std::string note;
  if (stretch != 1.0) {
    note = "heights x " + drawing::tick_label(stretch, stretch);
  }
  if (paths.longest_step > 1) {
    note += (note.empty() ? "" : "; ") + ("paths: every " + std::to_string(paths.longest_step) + "th pose");
  }
  return note;
}

void draw_trajectories_so_far(Canvas& canvas, const Rect& area, const Scene& scene) {
  const Paths whole = paths_of(scene);
  const Range x = range_along(whole, 0).at_least(kMin_m).widened(0.15);
  const Range z = range_along(whole, 2).at_least(kMin_m).widened(0.08);
  draw_plan(canvas, PlanView::lying(area, x, z), scene, paths_of(scene, scene.frame));
}

}  // namespace kinetrace::figure

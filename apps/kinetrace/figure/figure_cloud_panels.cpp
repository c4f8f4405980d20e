#include <algorithm>
#include <cmath>
#include <numeric>

#include "figure/figure_panels.hpp"
#include "figure/figure_plan.hpp"
#include "figure/figure_views.hpp"

namespace kinetrace::figure {
namespace {

using drawing::Canvas;
using drawing::Color;
using drawing::HorizontalAnchor;
using drawing::Point;
using drawing::Range;
using drawing::Rect;

constexpr double kDegree = 0.017453292519943295;

/// Gray values of a cloud for the panel: stretched to the cloud's contrast, but never white, which would be invisible.
class Toner {
 public:
  explicit Toner(const Cloud& cloud) {
    std::vector<double> grays;
    for (const CloudPoint& point : cloud.points) {
      grays.push_back(point.gray);
    }
    constexpr double kIgnored = 0.03;
    constexpr double kMinContrast = 32.0;
    range_ = drawing::quantile_range(grays, kIgnored).value_or(Range{0.0, 255.0}).at_least(kMinContrast);
  }
  [[nodiscard]] Color operator()(std::uint8_t gray) const {
    constexpr double kDarkest = 12.0;
    constexpr double kBrightest = 188.0;
    const double share = std::clamp((gray - range_.low) / range_.size(), 0.0, 1.0);
    const auto level = static_cast<std::uint8_t>(kDarkest + (kBrightest - kDarkest) * share);
    return {level, level, level};
  }

 private:
  Range range_;
};

void draw_panel(Canvas& canvas, const Rect& area) {
  canvas.rectangle(area, drawing::kPanel);
}
void draw_border(Canvas& canvas, const Rect& area) {
  canvas.outline(area, {.color = drawing::kFrame, .width_px = 1.0});
}

void draw_note(Canvas& canvas, const Rect& area, const std::string& note) {
  canvas.text(area.center(), note,
              {.size_px = 11.0, .color = drawing::kMuted, .horizontal = HorizontalAnchor::kCenter});
}

void draw_points(Canvas& canvas, const Onlooker& onlooker, const Cloud& cloud, double radius_px, double alpha) {
  const Toner tone(cloud);
  std::vector<std::pair<double, const CloudPoint*>> by_distance;
  for (const CloudPoint& point : cloud.points) {
    by_distance.emplace_back(onlooker.distance_m(point.position_m.cast<double>()), &point);
  }
  std::sort(by_distance.begin(), by_distance.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  for (const auto& [distance, point] : by_distance) {
    canvas.disk(onlooker.to_canvas(Eigen::Vector3d(point->position_m.cast<double>())), radius_px, tone(point->gray),
                alpha);
  }
}

std::vector<Line2> seen_by(const Onlooker& onlooker, const std::vector<Line3>& lines) {
  std::vector<Line2> images(lines.size());
  std::transform(lines.begin(), lines.end(), images.begin(),
                 [&](const Line3& line) { return line_on_canvas(onlooker, line); });
  return images;
}

/// Indices of points along a line at least `least_px` from the previous one, beginning with the first finite point.
std::vector<std::size_t> spaced(const Line2& line, double least_px) {
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i].allFinite() && (kept.empty() || (line[i] - line[kept.back()]).norm() >= least_px)) {
      kept.push_back(i);
    }
  }
  return kept;
}

/// Mean viewing direction and mean down direction of cameras.
Onlooker::Direction mean_view(const std::vector<Se3>& cameras) {
  Eigen::Vector3d forward = Eigen::Vector3d::Zero();
  Eigen::Vector3d down = Eigen::Vector3d::Zero();
  for (const Se3& camera : cameras) {
    forward += camera.rotation.col(2);
    down += camera.rotation.col(1);
  }
  Onlooker::Direction direction;
  // Without a significant mean, the first camera decides.
  const double enough = 0.2 * static_cast<double>(cameras.size());
  direction.forward = forward.norm() > enough ? forward : cameras.front().rotation.col(2);
  direction.down = down.norm() > enough ? down : cameras.front().rotation.col(1);
  return direction;
}

/// From behind and above, at the side angle with the largest scale.
Onlooker widest_view(Onlooker::Direction direction, const Onlooker::Subject& subject, const Rect& area) {
  direction.elevated_rad = 28.0 * kDegree;
  direction.aside_rad = 20.0 * kDegree;
  Onlooker best(direction, subject, area);
  for (const double aside_deg : {35.0, 50.0}) {
    direction.aside_rad = aside_deg * kDegree;
    const Onlooker other(direction, subject, area);
    if (other.pixels_per_metre() > 1.05 * best.pixels_per_metre()) {
      best = other;
    }
  }
  return best;
}

/// The chosen object in its own frame.
struct ObjectView {
  std::vector<Se3> T_obj_cam;  ///< Of the frames in which it was tracked.
  std::vector<Line3> box;      ///< Edges, object frame; empty if it never was tracked.
};

ObjectView view_of(const Scene& scene, const TrackRows& track) {
  ObjectView view;
  const recording::ObjectRow* box_from = nullptr;
  for (const recording::ObjectRow* row : track.rows) {
    const recording::CameraRow* camera = scene.run->camera_at(row->frame);
    if (row->status != BodyStatus::kTracked || camera == nullptr) {
      continue;
    }
    view.T_obj_cam.push_back(row->T_world_obj.inverse() * camera->T_world_cam);
    if (box_from == nullptr || row->frame <= scene.frame || box_from->frame < scene.frame) {
      box_from = row;
    }
  }
  if (box_from != nullptr) {
    view.box = edges_of(box_from->box);
    const Se3 T_obj_world = box_from->T_world_obj.inverse();
    for (Line3& edge : view.box) {
      for (Eigen::Vector3d& p : edge) {
        p = T_obj_world * p;
      }
    }
  }
  return view;
}

std::vector<Eigen::Vector3d> positions(const Cloud& cloud) {
  std::vector<Eigen::Vector3d> all;
  for (const CloudPoint& point : cloud.points) {
    all.emplace_back(point.position_m.cast<double>());
  }
  return all;
}

void draw_object_points(Canvas& canvas, const Rect& area, const Scene& scene, const ObjectView& view, Color color) {
  draw_panel(canvas, area);
  Onlooker::Direction direction = view.T_obj_cam.empty() ? Onlooker::Direction{} : mean_view(view.T_obj_cam);
  if (!view.T_obj_cam.empty()) {
    // Towards the object, independent of its place in the image.
    Eigen::Vector3d towards = Eigen::Vector3d::Zero();
    for (const Se3& camera : view.T_obj_cam) {
      towards -= camera.translation.normalized();
    }
    direction.forward = towards.norm() > 1e-3 ? towards : direction.forward;
  }
  direction.aside_rad = 22.0 * kDegree;
  direction.elevated_rad = 14.0 * kDegree;
  const std::vector<Eigen::Vector3d> seen = positions(scene.object_model);
  std::vector<Eigen::Vector3d> box;
  for (const Line3& edge : view.box) {
    box.insert(box.end(), edge.begin(), edge.end());
  }
  constexpr double kOutliers = 0.06;
  constexpr double kMargin_px = 14.0;
  const Onlooker onlooker(direction, {seen, kOutliers, box}, area.grown(-kMargin_px));
  canvas.clip(area);
  canvas.polylines(seen_by(onlooker, view.box), {.color = color, .width_px = 1.2, .alpha = 0.8});
  draw_points(canvas, onlooker, scene.object_model, 2.3, 0.95);
  draw_scale_bar(canvas, {area.right() - 16.0, area.bottom() - 16.0}, onlooker.pixels_per_metre(), area.width / 4);
  canvas.unclip();
  draw_border(canvas, area);
}

std::pair<Range, Range> ground_ranges(const std::vector<Eigen::Vector3d>& seen, double share) {
  std::vector<double> x;
  std::vector<double> z;
  for (const Eigen::Vector3d& p : seen) {
    x.push_back(p.x());
    z.push_back(p.z());
  }
  constexpr double kMin_m = 1.0;
  return {drawing::quantile_range(x, share).value_or(Range{-1.0, 1.0}).at_least(kMin_m),
          drawing::quantile_range(z, share).value_or(Range{-1.0, 1.0}).at_least(kMin_m)};
}

Range hull(const Range& a, const Range& b) {
  return {std::min(a.low, b.low), std::max(a.high, b.high)};
}

void draw_object_cameras(Canvas& canvas, const Rect& area, const Scene& scene, const ObjectView& view, Color color) {
  std::vector<Eigen::Vector3d> centers;
  for (const Se3& camera : view.T_obj_cam) {
    centers.push_back(camera.translation);
  }
  constexpr double kWildPoints = 0.05;
  constexpr double kWildCameras = 0.005;
  const auto [object_x, object_z] = ground_ranges(positions(scene.object_model), kWildPoints);
  const auto [camera_x, camera_z] =
      centers.empty() ? std::pair{object_x, object_z} : ground_ranges(centers, kWildCameras);
  const PlanView plan(area, hull(object_x, camera_x).widened(0.08), hull(object_z, camera_z).widened(0.08));
  plan.draw_axes(canvas);
  canvas.clip(area);
  canvas.polyline(line_on_canvas(plan, centers), {.color = drawing::kRed, .width_px = 1.2, .alpha = 0.7});
  constexpr double kWedge_px = 16.0;
  constexpr double kWedgeGap_px = 7.0;
  std::vector<Line2> wedges;
  for (const std::size_t i : spaced(line_on_canvas(plan, centers), kWedgeGap_px)) {
    wedges.push_back(
        line_on_canvas(plan, camera_wedge(view.T_obj_cam[i], scene.geometry, kWedge_px / plan.pixels_per_metre())));
  }
  canvas.polylines(wedges, {.color = drawing::kRed, .width_px = 1.3});
  std::vector<Line2> box;
  for (const Line3& edge : view.box) {
    box.push_back(line_on_canvas(plan, edge));
  }
  canvas.polylines(box, {.color = color, .width_px = 1.2, .alpha = 0.8});
  const Toner tone(scene.object_model);
  for (const CloudPoint& point : scene.object_model.points) {
    canvas.disk(plan.to_canvas(Eigen::Vector3d(point.position_m.cast<double>())), 1.3, tone(point.gray), 0.9);
  }
  canvas.unclip();
}

}  // namespace

void draw_scale_bar(Canvas& canvas, const Point& right_end, double pixels_per_metre, double longest_px) {
  if (!(pixels_per_metre > 0.0) || !std::isfinite(pixels_per_metre)) {
    return;
  }
  const double metres = drawing::round_below(longest_px / pixels_per_metre);
  const Point left = right_end - Point(metres * pixels_per_metre, 0.0);
  std::string length = metres < 0.995 ? drawing::tick_label(metres * 100.0, metres * 100.0) + " cm"
                                      : drawing::tick_label(metres, metres) + " m";
  canvas.line(left, right_end, {.color = drawing::kPaper, .width_px = 5.0, .alpha = 0.8});
  canvas.line(left, right_end, {.color = drawing::kInk, .width_px = 2.0});
  for (const Point& end : {left, right_end}) {
    canvas.line(end - Point(0.0, 4.0), end + Point(0.0, 4.0), {.color = drawing::kInk, .width_px = 1.5});
  }
  canvas.text((left + right_end) / 2.0 - Point(0.0, 8.0), length,
              {.size_px = 8.5, .horizontal = HorizontalAnchor::kCenter, .halo_px = 2.0});
}

void draw_object_reconstruction(Canvas& canvas, const Rect& area, const Scene& scene) {
  const TrackRows* track = scene.object ? scene.run->track(*scene.object) : nullptr;
  if (track == nullptr || scene.object_model.points.empty()) {
    draw_panel(canvas, area);
    draw_note(canvas, area,
              track == nullptr ? "no object was reconstructed"
                               : "no points of " + track_name(track->class_id, track->track_id));
    draw_border(canvas, area);
    return;
  }
  const ObjectView view = view_of(scene, *track);
  const Color color = drawing::track_style(track->track_id).color;
  constexpr double kShare = 0.42;
  draw_object_points(canvas, {area.x, area.y, area.width * kShare, area.height}, scene, view, color);
  const Rect right{area.x + area.width * kShare + 8.0, area.y, area.width * (1.0 - kShare) - 8.0, area.height};
  draw_object_cameras(canvas, drawing::inside_margins(right), scene, view, color);
}

void draw_background_reconstruction(Canvas& canvas, const Rect& area, const Scene& scene) {
  draw_panel(canvas, area);
  if (scene.background.points.empty()) {
    draw_note(canvas, area, "no points");
    draw_border(canvas, area);
    return;
  }
  const auto& rows = scene.run->run().camera;
  std::vector<Se3> cameras;
  Line3 path;
  constexpr std::size_t kPathPoints = 4000;
  const std::size_t step = every_nth(rows.size(), kPathPoints);
  for (std::size_t i = 0; i < rows.size(); i += step) {
    cameras.push_back(rows[i].T_world_cam);
    path.push_back(rows[i].T_world_cam.translation);
  }
  const std::vector<Eigen::Vector3d> points = positions(scene.background);
  constexpr double kOutliers = 0.04;
  const Onlooker onlooker = widest_view(mean_view(cameras), {points, kOutliers, path}, area);
  canvas.clip(area);
  draw_points(canvas, onlooker, scene.background, 1.25, 0.9);
  canvas.polyline(line_on_canvas(onlooker, path), {.color = drawing::kPaper, .width_px = 5.0, .alpha = 0.6});
  canvas.polyline(line_on_canvas(onlooker, path), {.color = drawing::kRed, .width_px = 2.2});
  constexpr double kPyramid_px = 16.0;
  constexpr double kPyramidGap_px = 44.0;
  std::vector<Line2> pyramids;
  for (const std::size_t i : spaced(line_on_canvas(onlooker, path), kPyramidGap_px)) {
    for (const Line2& line :
         seen_by(onlooker, camera_pyramid(cameras[i], scene.geometry, kPyramid_px / onlooker.pixels_per_metre()))) {
      pyramids.push_back(line);
    }
  }
  canvas.polylines(pyramids, {.color = drawing::kRed, .width_px = 1.1});
  canvas.unclip();
  draw_border(canvas, area);
}

}  // namespace kinetrace::figure

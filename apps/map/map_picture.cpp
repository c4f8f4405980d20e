#include "map_picture.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "drawing/axes.hpp"
#include "drawing/canvas.hpp"
#include "drawing/label_placer.hpp"

namespace kinetrace::map {
namespace {

using drawing::Canvas;
using drawing::Point;
using drawing::Range;
using drawing::Rect;

constexpr int kWidth_px = 1200;
constexpr double kMaxHeight_px = 1200.0;
constexpr double kMinHeight_px = 420.0;
constexpr double kEdge_px = 24.0;
constexpr double kTitle_px = 44.0;
constexpr double kMinExtent_m = 10.0;
constexpr std::size_t kMaxLabels = 24;

/// Range along one axis of the paths of camera and moving objects, and of the inlier fixes.
Range range_along(Eigen::Index axis, std::span<const geo::MapTrajectory> trajectories, const geo::Reference& reference,
                  const geo::Alignment& alignment) {
  Range range{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  const auto include = [&](const Eigen::Vector3d& p) {
    range = {std::min(range.low, p[axis]), std::max(range.high, p[axis])};
  };
  for (const geo::MapTrajectory& trajectory : trajectories) {
    if (trajectory.id == 0 || trajectory.moving) {
      for (const geo::MapPoint& point : trajectory.points) {
        include(point.enu_m);
      }
    }
  }
  for (std::size_t i = 0; i < reference.fixes.size(); ++i) {
    if (alignment.use[i] == geo::FixUse::kInlier) {
      include(reference.fixes[i].enu_m);
    }
  }
  return range.at_least(kMinExtent_m).widened(0.08);
}

/// Both axes to the same scale.
drawing::Axes make_axes(const Rect& area, Range east, Range north) {
  const double metres_per_px = std::max(east.size() / area.width, north.size() / area.height);
  return {area,
          {.label = "east [m]", .range = east.at_least(metres_per_px * area.width)},
          {.label = "north [m]", .range = north.at_least(metres_per_px * area.height)}};
}

void draw_fixes(Canvas& canvas, const drawing::Axes& axes, const geo::Reference& reference,
                const geo::Alignment& alignment) {
  for (std::size_t i = 0; i < reference.fixes.size(); ++i) {
    const Point p = axes.to_canvas(reference.fixes[i].enu_m.x(), reference.fixes[i].enu_m.y());
    if (alignment.use[i] != geo::FixUse::kOutlier) {
      canvas.disk(p, 2.5, drawing::kMuted, 0.55);
    } else {
      constexpr double kCross_px = 3.5;
      canvas.line(p - Point(kCross_px, kCross_px), p + Point(kCross_px, kCross_px), {.color = drawing::kRed});
      canvas.line(p - Point(kCross_px, -kCross_px), p + Point(kCross_px, -kCross_px), {.color = drawing::kRed});
    }
  }
}

std::vector<Point> line_of(const drawing::Axes& axes, const geo::MapTrajectory& trajectory) {
  std::vector<Point> line;
  for (const geo::MapPoint& point : trajectory.points) {
    if (point.is_after_gap) {
      line.emplace_back(Point::Constant(std::numeric_limits<double>::quiet_NaN()));
    }
    line.push_back(axes.to_canvas(point.enu_m.x(), point.enu_m.y()));
  }
  return line;
}

drawing::Stroke stroke_of(const geo::MapTrajectory& trajectory) {
  if (trajectory.id == 0) {
    return {.color = drawing::kInk, .width_px = 2.6};
  }
  const drawing::LineStyle style = drawing::track_style(trajectory.id);
  return trajectory.moving ? drawing::Stroke{.color = style.color, .width_px = 2.2, .dash = style.dash}
                           : drawing::Stroke{.color = style.color, .width_px = 1.2, .alpha = 0.5};
}

void draw_paths(Canvas& canvas, const drawing::Axes& axes, std::span<const geo::MapTrajectory> trajectories) {
  drawing::LabelPlacer placer(axes.area().grown(-3.0));
  // The camera comes first, and is drawn on top.
  for (auto trajectory = trajectories.rbegin(); trajectory != trajectories.rend(); ++trajectory) {
    const std::vector<Point> line = line_of(axes, *trajectory);
    canvas.polyline(line, stroke_of(*trajectory));
    canvas.disk(line.back(), trajectory->moving ? 3.5 : 2.5, stroke_of(*trajectory).color);
    placer.avoid(line);
  }
  std::size_t labels = 0;
  for (const geo::MapTrajectory& trajectory : trajectories) {
    const Point anchor = line_of(axes, trajectory).back();
    const drawing::TextStyle style{.size_px = 9.0,
                                   .color = drawing::mix(stroke_of(trajectory).color, drawing::kInk, 0.35),
                                   .horizontal = drawing::HorizontalAnchor::kCenter,
                                   .vertical = drawing::VerticalAnchor::kMiddle,
                                   .halo_px = 2.0,
                                   .halo = drawing::kPanel};
    const std::string name = trajectory.name();
    if (!trajectory.moving || !axes.area().contains(anchor) || labels++ >= kMaxLabels) {
      continue;
    }
    if (const auto place = placer.place(anchor, drawing::text_width(name, style) + 4.0, 15.0, 7.0)) {
      canvas.text(place->center(), name, style);
    }
  }
}

std::string title(const geo::Reference& reference) {
  const geo::Geodetic& origin = reference.frame.origin();
  char text[160];
  std::snprintf(text, sizeof text, "north up; metres about %.7f, %.7f (WGS84)", origin.latitude_deg,
                origin.longitude_deg);
  return text;
}

}  // namespace

Status write_map_picture(const std::filesystem::path& file, std::span<const geo::MapTrajectory> trajectories,
                         const geo::Reference& reference, const geo::Alignment& alignment) {
  const Range east = range_along(0, trajectories, reference, alignment);
  const Range north = range_along(1, trajectories, reference, alignment);
  const Rect widest = drawing::inside_margins({kEdge_px, kTitle_px, kWidth_px - 2 * kEdge_px, kMaxHeight_px});
  const double wanted_px = std::clamp(north.size() * widest.width / east.size(), kMinHeight_px, kMaxHeight_px);
  const Rect area{widest.x, widest.y, widest.width, wanted_px};
  Canvas canvas(kWidth_px, static_cast<int>(area.bottom() + drawing::kMarginBelow_px + kEdge_px), drawing::kPaper);
  const drawing::Axes axes = make_axes(area, east, north);
  axes.draw(canvas);
  canvas.clip(area);
  draw_fixes(canvas, axes, reference, alignment);
  draw_paths(canvas, axes, trajectories);
  canvas.unclip();
  const drawing::TextStyle caption{.size_px = 9.0, .color = drawing::kMuted};
  canvas.text({area.x, kTitle_px - 16.0}, title(reference), caption);
  const drawing::TextStyle legend{
      .size_px = 9.0, .color = drawing::kMuted, .horizontal = drawing::HorizontalAnchor::kRight};
  canvas.text({area.right(), kTitle_px - 16.0}, "reference: dots, outliers crossed", legend);
  return canvas.write_png(file);
}

}  // namespace kinetrace::map

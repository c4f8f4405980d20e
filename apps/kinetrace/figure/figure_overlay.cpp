#include "figure/figure_overlay.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <system_error>
#include <utility>

#include "drawing/chips.hpp"
#include "figure/figure_panels.hpp"
#include "figure/figure_views.hpp"
#include "figure/picture_place.hpp"

namespace kinetrace::figure {
namespace {

using drawing::Canvas;
using drawing::Color;
using drawing::Point;
using drawing::Rect;

constexpr double kTextSize_px = 6.5;  ///< At line_px 1.

/// One frame being drawn.
struct OverlayFrame {
  const FigureRun& run;
  std::int64_t frame;
  const recording::CameraRow& camera;
  const StereoGeometry& geometry;
  ImagePlace place;
  double line_px;  ///< Lines and text grow with the image.
};

void draw_masks(Canvas& canvas, const OverlayFrame& frame, const std::vector<TrackMask>& masks) {
  for (const TrackMask& mask : masks) {
    const GrayView view{mask.pixels.data(), frame.place.width_px, frame.place.height_px, frame.place.width_px};
    const Color color = drawing::track_style(mask.track_id).color;
    canvas.mask(view, frame.place.rect, color, 0.38);
    canvas.mask_outline(view, frame.place.rect, {.color = color, .width_px = frame.line_px});
  }
}

std::vector<Line3> in_camera(std::vector<Line3> lines, const Se3& T_world_cam) {
  const Se3 T_cam_world = T_world_cam.inverse();
  for (Line3& line : lines) {
    for (Eigen::Vector3d& p : line) {
      p = T_cam_world * p;
    }
  }
  return lines;
}

void draw_trail(Canvas& canvas, const OverlayFrame& frame, const recording::ObjectRow& object) {
  const TrackRows& track = *frame.run.track(object.track_id);
  const auto now = std::find(track.rows.begin(), track.rows.end(), &object);
  const auto first = now - std::min<std::ptrdiff_t>(now - track.rows.begin(), kTrailFrames);
  std::vector<Line3> pieces;
  for (auto row = first; row != now; ++row) {
    if ((*row)->status != BodyStatus::kLost && (*(row + 1))->status != BodyStatus::kLost) {
      pieces.push_back({(*row)->box.center_m, (*(row + 1))->box.center_m});
    }
  }
  const std::vector<Line2> lines =
      project_lines(in_camera(std::move(pieces), frame.camera.T_world_cam), frame.geometry, frame.place);
  const Color color = drawing::track_style(object.track_id).color;
  canvas.polylines(lines, {.color = drawing::kPaper, .width_px = 3.0 * frame.line_px, .alpha = 0.5});
  canvas.polylines(lines, {.color = color, .width_px = 1.8 * frame.line_px});
}

/// Draws the box, clipped at kMinProjectionDepth_m.
void draw_box(Canvas& canvas, const OverlayFrame& frame, const recording::ObjectRow& object) {
  const std::vector<Line2> lines =
      project_lines(in_camera(edges_of(object.box), frame.camera.T_world_cam), frame.geometry, frame.place);
  const Color color = drawing::track_style(object.track_id).color;
  canvas.polylines(lines, {.color = drawing::kPaper, .width_px = 2.2 * frame.line_px, .alpha = 0.45});
  canvas.polylines(lines, {.color = color, .width_px = 1.2 * frame.line_px});
}

/// Where a label for this object belongs: above its mask, or above the middle of its box.
std::optional<Rect> label_target(const OverlayFrame& frame, const recording::ObjectRow* object, const TrackMask* mask) {
  if (mask != nullptr) {
    const Point low = frame.place.to_canvas(mask->box_px.x0 - 0.5, mask->box_px.y0 - 0.5);
    const Point high = frame.place.to_canvas(mask->box_px.x1 - 0.5, mask->box_px.y1 - 0.5);
    return Rect{low.x(), low.y(), high.x() - low.x(), high.y() - low.y()};
  }
  if (object != nullptr) {
    const Eigen::Vector3d center = frame.camera.T_world_cam.inverse() * object->box.center_m;
    if (center.z() > kMinProjectionDepth_m) {
      const Eigen::Vector3d uv = frame.geometry.project(center);
      const Point p = frame.place.to_canvas(uv.x(), uv.y());
      if (frame.place.rect.contains(p)) {
        return Rect{p.x(), p.y(), 0.0, 0.0};
      }
    }
  }
  return std::nullopt;
}

/// Data of one track in this frame.
struct Seen {
  const recording::ObjectRow* object = nullptr;  ///< None while it is still initializing.
  const TrackMask* mask = nullptr;
};

void draw_names(Canvas& canvas, const OverlayFrame& frame, const std::map<std::uint32_t, Seen>& seen) {
  std::vector<drawing::Chip> chips;
  for (const auto& [id, track] : seen) {
    if (const std::optional<Rect> target = label_target(frame, track.object, track.mask)) {
      drawing::Chip& chip = chips.emplace_back();
      if (track.object != nullptr) {
        chip.texts.push_back(object_label(*track.object, frame.camera.T_world_cam));
      }
      chip.texts.push_back(track_name(track.object != nullptr ? track.object->class_id : track.mask->class_id, id));
      chip.texts.push_back(std::to_string(id));
      chip.color = drawing::track_style(id).color;
      chip.target = *target;
    }
  }
  draw_chips(canvas, frame.place.rect, std::move(chips), kTextSize_px * frame.line_px);
}

void draw_status(Canvas& canvas, const OverlayFrame& frame) {
  const auto& rows = frame.run.run().camera;
  const std::ptrdiff_t index = &frame.camera - rows.data();
  std::string text =
      "frame " + std::to_string(frame.frame) + "   " + with_unit(frame.run.seconds(frame.camera.timestamp_ns), 2, "s");
  if (rows.size() > 1) {
    const recording::CameraRow& before = rows[static_cast<std::size_t>(std::max<std::ptrdiff_t>(index - 1, 0))];
    const recording::CameraRow& after = rows[static_cast<std::size_t>(std::max<std::ptrdiff_t>(index, 1))];
    const double elapsed_s = static_cast<double>(after.timestamp_ns - before.timestamp_ns) * 1e-9;
    const double way_m = (after.T_world_cam.translation - before.T_world_cam.translation).norm();
    text += "   camera " + with_unit(way_m / elapsed_s, 1, "m/s");
  }
  const drawing::TextStyle style{
      .size_px = kTextSize_px * frame.line_px, .color = drawing::kPaper, .vertical = drawing::VerticalAnchor::kMiddle};
  const double height = 2.0 * style.size_px;
  const Rect strip{frame.place.rect.x, frame.place.rect.bottom() - height,
                   text_width(text, style) + 2.0 * style.size_px, height};
  canvas.rectangle(strip, drawing::kInk, 0.65);
  canvas.text({strip.x + style.size_px, strip.center().y()}, text, style);
}

}  // namespace

void draw_overlay(Canvas& canvas, const Rect& area, const FigureRun& run, std::int64_t frame_number, GrayView image,
                  const StereoGeometry& geometry, const std::vector<TrackMask>& masks) {
  canvas.image(image, area);
  const recording::CameraRow* camera = run.camera_at(frame_number);
  if (camera == nullptr) {
    return;
  }
  canvas.clip(area);
  const OverlayFrame frame{run,
                           frame_number,
                           *camera,
                           geometry,
                           {area, image.width, image.height},
                           std::clamp(area.width / 900.0, 1.0, 2.2)};
  std::map<std::uint32_t, Seen> seen;
  for (const TrackMask& mask : masks) {
    seen[mask.track_id].mask = &mask;
  }
  draw_masks(canvas, frame, masks);
  for (const recording::ObjectRow& object : run.objects_at(frame_number)) {
    if (object.status == BodyStatus::kLost) {
      continue;
    }
    seen[object.track_id].object = &object;
    if (object.moving) {
      draw_trail(canvas, frame, object);
    }
    if (object.status == BodyStatus::kTracked) {
      draw_box(canvas, frame, object);
    }
  }
  draw_names(canvas, frame, seen);
  draw_status(canvas, frame);
  canvas.unclip();
}

Canvas draw_overlay(const FigureRun& run, std::int64_t frame, GrayView image, const StereoGeometry& geometry,
                    const std::vector<TrackMask>& masks) {
  Canvas canvas(image.width, image.height, drawing::kPaper);
  const Rect whole{0.0, 0.0, static_cast<double>(image.width), static_cast<double>(image.height)};
  draw_overlay(canvas, whole, run, frame, image, geometry, masks);
  return canvas;
}

Result<std::int64_t> write_frames(const FigureRun& run, RecordedImages& images, recording::MaskFrames& masks,
                                  const std::filesystem::path& directory, const FrameDrawing& draw,
                                  const std::function<bool(std::int64_t, int)>& progress) {
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  if (!std::filesystem::is_directory(directory, error)) {
    return fail(ErrorCode::kIo,
                directory.string() + ": cannot be made; --overlay and --film need a folder that can be written");
  }
  if (const Status apart = check_apart(directory, images.frames()); !apart) {
    return Unexpected(apart.error());
  }
  std::int64_t written = 0;
  for (const recording::CameraRow& camera : run.run().camera) {
    const std::string stem = images.stem(camera.frame);
    if (stem.empty()) {
      continue;
    }
    const Result<GrayView> image = images.left(camera.frame);
    if (!image) {
      return Unexpected(image.error());
    }
    const Result<recording::MaskFrame> labels = masks.at(camera.frame);
    if (!labels) {
      return Unexpected(labels.error());
    }
    const std::filesystem::path file = directory / (stem + ".png");
    if (const Status free = check_replaceable(file); !free) {
      return Unexpected(free.error());
    }
    const std::vector<TrackMask> parts = separate(*labels);
    const Canvas canvas = draw(camera.frame, *image, parts);
    if (const Status saved = canvas.write_png(file, imaging::PngEffort::kFast); !saved) {
      return Unexpected(saved.error());
    }
    ++written;
    if (!progress(written, static_cast<int>(parts.size()))) {
      break;
    }
  }
  return written;
}

Result<std::int64_t> write_overlay(const FigureRun& run, RecordedImages& images, recording::MaskFrames& masks,
                                   const std::filesystem::path& directory,
                                   const std::function<bool(std::int64_t, int)>& progress) {
  const auto draw = [&](std::int64_t frame, GrayView image, const std::vector<TrackMask>& parts) {
    return draw_overlay(run, frame, image, images.geometry(), parts);
  };
  return write_frames(run, images, masks, directory, draw, progress);
}

}  // namespace kinetrace::figure

#include <algorithm>
#include <array>
#include <cmath>

#include "drawing/chips.hpp"
#include "figure/figure_panels.hpp"
#include "figure/figure_views.hpp"

namespace kinetrace::figure {
namespace {

using drawing::Canvas;
using drawing::Color;
using drawing::HorizontalAnchor;
using drawing::Point;
using drawing::Rect;
using drawing::TextStyle;
using drawing::VerticalAnchor;

constexpr double kLabelSize_px = 8.5;
constexpr double kRow_px = 21.0;

// The largest rectangle of the image's shape, centred in the area.
ImagePlace place_of(const Rect& area, const Scene& scene) {
  const double scale = std::min(area.width / scene.geometry.width_px, area.height / scene.geometry.height_px);
  const double width = scale * scene.geometry.width_px;
  const double height = scale * scene.geometry.height_px;
  const Point middle = area.center();
  return {{std::round(middle.x() - width / 2), std::round(middle.y() - height / 2), width, height},
          scene.geometry.width_px,
          scene.geometry.height_px};
}

void say(Canvas& canvas, const Rect& area, const std::string& what, const std::string& why) {
  const TextStyle style{.size_px = 11.0, .color = drawing::kMuted, .horizontal = HorizontalAnchor::kCenter};
  canvas.text(area.center(), what, style);
  TextStyle small = style;
  small.size_px = kLabelSize_px;
  canvas.text(area.center() + Point(0.0, 20.0), drawing::shortened(why, area.width - 24.0, small), small);
}

void draw_frame(Canvas& canvas, const ImagePlace& place) {
  canvas.outline(place.rect, {.color = drawing::kFrame, .width_px = 1.0});
}

/// The image, or a panel of its size; false if there is none.
bool draw_image(Canvas& canvas, const ImagePlace& place, const Scene& scene, double fade) {
  if (scene.image.empty()) {
    canvas.rectangle(place.rect, drawing::kPanel);
    return false;
  }
  canvas.image(scene.image_view(), place.rect, fade);
  return true;
}

Rect on_canvas(const ImagePlace& place, const PixelBox& box) {
  const Point low = place.to_canvas(box.x0 - 0.5, box.y0 - 0.5);
  const Point high = place.to_canvas(box.x1 - 0.5, box.y1 - 0.5);
  return {low.x(), low.y(), high.x() - low.x(), high.y() - low.y()};
}

drawing::Chip chip_of(std::uint16_t class_id, std::uint32_t track_id, const Rect& target) {
  return {{track_name(class_id, track_id), std::to_string(track_id)}, drawing::track_style(track_id).color, target};
}

std::string status_words(BodyStatus status) {
  switch (status) {
    case BodyStatus::kTracked: return "tracked";
    case BodyStatus::kStereoOnly: return "stereo only";
    case BodyStatus::kPropagated: return "propagated";
    case BodyStatus::kInitializing:
    case BodyStatus::kLost: break;
  }
  return "lost";
}

}  // namespace

std::string object_label(const recording::ObjectRow& object, const Se3& T_world_cam) {
  std::string label = track_name(object.class_id, object.track_id);
  if (object.moving) {
    label += "  " + with_unit(object.velocity_mps.norm(), 1, "m/s");
  }
  return label + "  " + with_unit((object.box.center_m - T_world_cam.translation).norm(), 1, "m");
}

void draw_input(Canvas& canvas, const Rect& area, const Scene& scene) {
  const ImagePlace place = place_of(area, scene);
  if (!draw_image(canvas, place, scene, 0.0)) {
    say(canvas, place.rect, "no image", scene.image_problem);
  }
  draw_frame(canvas, place);
}

void draw_object_segmentation(Canvas& canvas, const Rect& area, const Scene& scene) {
  const ImagePlace place = place_of(area, scene);
  draw_image(canvas, place, scene, 0.45);
  canvas.clip(place.rect);
  std::vector<drawing::Chip> names;
  for (const TrackMask& mask : scene.masks) {
    const Color color = drawing::track_style(mask.track_id).color;
    canvas.mask(scene.mask_view(mask), place.rect, color, 0.55);
    canvas.mask_outline(scene.mask_view(mask), place.rect, {.color = color, .width_px = 1.5});
    names.push_back(chip_of(mask.class_id, mask.track_id, on_canvas(place, mask.box_px)));
  }
  if (scene.masks.empty()) {
    for (const recording::ObjectRow& object : scene.run->objects_at(scene.frame)) {
      if (object.status != BodyStatus::kLost && !object.mask_px.empty()) {
        const Color color = drawing::track_style(object.track_id).color;
        canvas.outline(on_canvas(place, object.mask_px), {.color = color, .width_px = 2.0});
        names.push_back(chip_of(object.class_id, object.track_id, on_canvas(place, object.mask_px)));
      }
    }
  }
  draw_chips(canvas, place.rect, names, kLabelSize_px);
  canvas.unclip();
  if (names.empty()) {
    const Rect note{place.rect.center().x() - 70.0, place.rect.center().y() - 14.0, 140.0, 28.0};
    canvas.rectangle(note, drawing::kPaper, 0.8);
    canvas.text(note.center(), "no objects",
                {.size_px = 11.0,
                 .color = drawing::kMuted,
                 .horizontal = HorizontalAnchor::kCenter,
                 .vertical = VerticalAnchor::kMiddle});
  }
  draw_frame(canvas, place);
}

void draw_background_segmentation(Canvas& canvas, const Rect& area, const Scene& scene) {
  const ImagePlace place = place_of(area, scene);
  const bool has_image = draw_image(canvas, place, scene, 0.0);
  canvas.clip(place.rect);
  for (const TrackMask& mask : scene.masks) {
    canvas.mask(scene.mask_view(mask), place.rect, has_image ? drawing::kPaper : drawing::kGrid, 1.0);
  }
  canvas.unclip();
  if (!has_image) {
    say(canvas, place.rect, "no image", scene.image_problem);
  }
  draw_frame(canvas, place);
}

namespace {

// Largest in the image first.
std::vector<const recording::ObjectRow*> visible_objects(const Scene& scene) {
  std::vector<const recording::ObjectRow*> objects;
  for (const recording::ObjectRow& object : scene.run->objects_at(scene.frame)) {
    if (object.status != BodyStatus::kLost) {
      objects.push_back(&object);
    }
  }
  std::stable_sort(objects.begin(), objects.end(),
                   [](const auto* a, const auto* b) { return a->pixel_height > b->pixel_height; });
  return objects;
}

using Cells = std::array<std::string, 6>;

Cells cells_of(const recording::ObjectRow& object, const recording::CameraRow& camera) {
  return {track_name(object.class_id, object.track_id),
          object.moving ? with_unit(object.velocity_mps.norm(), 1, "m/s")
                        : std::string(object.status == BodyStatus::kTracked ? "static" : "?"),
          with_unit((object.box.center_m - camera.T_world_cam.translation).norm(), 1, "m"),
          object.pixel_height > 0 ? with_unit(object.pixel_height, 0, "px") : std::string("-"),
          std::to_string(object.point_count),
          status_words(object.status)};
}

double column_x(const Rect& area, double share) {
  return area.x + share * area.width;
}

void draw_cells(Canvas& canvas, const Rect& area, double y, const Cells& cells, Color color) {
  constexpr std::array<double, 6> kPlaces{0.085, 0.42, 0.56, 0.68, 0.79, 0.83};
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const bool is_text = i == 0 || i + 1 == cells.size();
    TextStyle style{.size_px = 9.0, .color = color, .vertical = VerticalAnchor::kMiddle};
    style.horizontal = is_text ? style.horizontal : HorizontalAnchor::kRight;
    canvas.text({column_x(area, kPlaces[i]), y}, cells[i], style);
  }
}

}  // namespace

void draw_object_table(Canvas& canvas, const Rect& area, const Scene& scene) {
  const std::vector<const recording::ObjectRow*> objects = visible_objects(scene);
  canvas.rectangle(area, drawing::kPanel);
  canvas.outline(area, {.color = drawing::kFrame, .width_px = 1.0});
  if (objects.empty()) {
    say(canvas, area, "no objects in this frame", "");
    return;
  }
  double y = area.y + 16.0;
  draw_cells(canvas, area, y, {"object", "speed", "distance", "height", "points", "pose"}, drawing::kMuted);
  canvas.line({area.x + 10.0, y + 11.0}, {area.right() - 10.0, y + 11.0}, {.color = drawing::kFrame, .width_px = 1.0});
  y += 4.0;
  const auto room = static_cast<std::size_t>(std::max(1.0, std::floor((area.bottom() - y - 14.0) / kRow_px)));
  const std::size_t shown = objects.size() <= room ? objects.size() : room - 1;
  const recording::CameraRow& camera = *scene.run->camera_at(scene.frame);
  for (std::size_t i = 0; i < shown; ++i) {
    y += kRow_px;
    const drawing::LineStyle style = drawing::track_style(objects[i]->track_id);
    canvas.line({column_x(area, 0.018), y}, {column_x(area, 0.068), y},
                {.color = style.color, .width_px = 3.0, .dash = style.dash});
    draw_cells(canvas, area, y, cells_of(*objects[i], camera), drawing::kInk);
  }
  if (shown < objects.size()) {
    canvas.text({column_x(area, 0.085), y + kRow_px}, "and " + std::to_string(objects.size() - shown) + " more",
                {.size_px = 9.0, .color = drawing::kMuted, .vertical = VerticalAnchor::kMiddle});
  }
}

}  // namespace kinetrace::figure

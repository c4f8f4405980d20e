#include "figure/figure_page.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "drawing/axes.hpp"
#include "figure/figure_panels.hpp"

namespace kinetrace::figure {
namespace {

using drawing::Canvas;
using drawing::Rect;

constexpr double kMargin_px = 36.0;
constexpr double kGutter_px = 28.0;
constexpr double kTitle_px = 44.0;
constexpr double kCaption_px = 34.0;  ///< Above a panel.
constexpr double kColumn_px = (kPageWidth_px - 2 * kMargin_px - kGutter_px) / 2;
constexpr double kCloud_px = 410.0;
constexpr double kWide_px = kPageWidth_px - 2 * kMargin_px;

/// Layout; panels without their captions.
struct Layout {
  Rect input, objects, background, table, object_cloud, background_cloud;
  TrajectoryAreas paths;
  int height_px = 0;
};

Rect column(int index, double y, double height) {
  return {kMargin_px + index * (kColumn_px + kGutter_px), y, kColumn_px, height};
}

Layout layout_of(const Scene& scene) {
  Layout layout;
  const double aspect = static_cast<double>(scene.geometry.width_px) / scene.geometry.height_px;
  const double image_px = std::round(std::clamp(kColumn_px / aspect, 170.0, 380.0));
  double y = kMargin_px + kTitle_px + kCaption_px;
  layout.input = column(0, y, image_px);
  layout.objects = column(1, y, image_px);
  y += image_px + kCaption_px + 6.0;
  layout.background = column(0, y, image_px);
  layout.table = column(1, y, image_px);
  y += image_px + kCaption_px + 6.0;
  layout.object_cloud = column(0, y, kCloud_px);
  layout.background_cloud = column(1, y, kCloud_px);
  y += kCloud_px + kCaption_px + 6.0;
  const double elongation = path_elongation(scene);
  constexpr double kLong = 3.0;
  layout.paths.stacked = elongation > kLong;
  if (layout.paths.stacked) {
    // Height that follows from the paths' extent when their length fills the page.
    const double wide_px = kWide_px - drawing::kMarginLeft_px;
    const double top_px = std::clamp(std::round(wide_px / elongation), 240.0, 420.0) + drawing::kMarginBelow_px;
    constexpr double kSide_px = 230.0;
    layout.paths.top = drawing::inside_margins({kMargin_px, y, kWide_px, top_px});
    y += top_px + kCaption_px + 6.0;
    layout.paths.side = drawing::inside_margins({kMargin_px, y, kWide_px, kSide_px});
    y += kSide_px;
  } else {
    constexpr double kBoth_px = 480.0;
    layout.paths.top = drawing::inside_margins(column(0, y, kBoth_px));
    layout.paths.side = drawing::inside_margins(column(1, y, kBoth_px));
    y += kBoth_px;
  }
  layout.height_px = static_cast<int>(std::ceil(y + kMargin_px * 0.7));
  return layout;
}

/// "(a) Title", and muted details at the right.
void draw_caption(Canvas& canvas, const Rect& panel, double left, const std::string& title, const std::string& detail) {
  const drawing::TextStyle style{.size_px = 10.5, .bold = true};
  const double base = panel.y - 11.0;
  canvas.text({left, base}, title, style);
  const drawing::TextStyle small{
      .size_px = 8.5, .color = drawing::kMuted, .horizontal = drawing::HorizontalAnchor::kRight};
  const double room = panel.right() - left - text_width(title, style) - 20.0;
  if (!detail.empty()) {
    canvas.text({panel.right(), base}, drawing::shortened(detail, room, small), small);
  }
}

std::string sampling(const Cloud& cloud) {
  return cloud.every > 1 ? ", every " + std::to_string(cloud.every) + "th" : "";
}

std::string points_of(const Cloud& cloud) {
  return std::to_string(cloud.points.size()) + " points" + sampling(cloud);
}

/// Objects without masks would look like background.
std::string mask_note(const Scene& scene) {
  return scene.masks.empty() && !scene.run->objects_at(scene.frame).empty() ? "objects not removed: no masks" : "";
}

std::string object_title(const Scene& scene) {
  const TrackRows* track = scene.object ? scene.run->track(*scene.object) : nullptr;
  return track == nullptr ? std::string() : ", " + track_name(track->class_id, track->track_id);
}

std::string object_detail(const Scene& scene) {
  const TrackRows* track = scene.object ? scene.run->track(*scene.object) : nullptr;
  if (track == nullptr || scene.object_model.points.empty()) {
    return "";
  }
  const auto cameras = std::count_if(track->rows.begin(), track->rows.end(),
                                     [](const auto* row) { return row->status == BodyStatus::kTracked; });
  return points_of(scene.object_model) + "; " + std::to_string(cameras) + " cameras, red";
}

double path_length_m(const recording::Run& run) {
  double length = 0.0;
  for (std::size_t i = 1; i < run.camera.size(); ++i) {
    length += (run.camera[i].T_world_cam.translation - run.camera[i - 1].T_world_cam.translation).norm();
  }
  return length;
}

void draw_title(Canvas& canvas, const Scene& scene) {
  const recording::Run& run = scene.run->run();
  const recording::CameraRow& camera = *scene.run->camera_at(scene.frame);
  const std::string name = run.sequence.empty() ? run.directory.filename().string() : run.sequence;
  const std::string about = "frame " + std::to_string(scene.frame) + " of " + std::to_string(scene.run->first_frame()) +
                            " to " + std::to_string(scene.run->last_frame()) + ", " +
                            with_unit(scene.run->seconds(camera.timestamp_ns), 2, "s") + "; camera path " +
                            with_unit(path_length_m(run), 1, "m") + ", " + std::to_string(scene.run->tracks().size()) +
                            (scene.run->tracks().size() == 1 ? " object" : " objects");
  const drawing::TextStyle small{
      .size_px = 10.0, .color = drawing::kMuted, .horizontal = drawing::HorizontalAnchor::kRight};
  const drawing::TextStyle large{.size_px = 15.0, .bold = true};
  const double base = kMargin_px + 16.0;
  canvas.text({kPageWidth_px - kMargin_px, base}, about, small);
  canvas.text({kMargin_px, base}, drawing::shortened(name, kWide_px - text_width(about, small) - 30.0, large), large);
  canvas.line({kMargin_px, kMargin_px + 32.0}, {kPageWidth_px - kMargin_px, kMargin_px + 32.0},
              {.color = drawing::kFrame, .width_px = 1.0});
}

}  // namespace

Canvas draw_page(const Scene& scene) {
  const Layout layout = layout_of(scene);
  Canvas canvas(kPageWidth_px, layout.height_px, drawing::kPaper);
  draw_title(canvas, scene);
  const auto caption = [&](const Rect& panel, const std::string& title, const std::string& detail) {
    draw_caption(canvas, panel, panel.x, title, detail);
  };
  caption(layout.input, "(a) Input frame", "left, rectified");
  draw_input(canvas, layout.input, scene);
  caption(layout.objects, "(b) Object segmentation", "colour: track, the same in all panels");
  draw_object_segmentation(canvas, layout.objects, scene);
  caption(layout.background, "(c) Background segmentation", mask_note(scene));
  draw_background_segmentation(canvas, layout.background, scene);
  caption(layout.table, "(d) Objects in this frame", "");
  draw_object_table(canvas, layout.table, scene);
  caption(layout.object_cloud, "(e) Object reconstruction" + object_title(scene), object_detail(scene));
  draw_object_reconstruction(canvas, layout.object_cloud, scene);
  caption(layout.background_cloud, "(f) Background reconstruction", points_of(scene.background) + "; cameras, red");
  draw_background_reconstruction(canvas, layout.background_cloud, scene);
  const std::string note = draw_trajectories(canvas, layout.paths, scene);
  // Aligned with the panels above, not with the axes.
  const double side_left = layout.paths.stacked ? kMargin_px : kMargin_px + kColumn_px + kGutter_px;
  draw_caption(canvas, layout.paths.top, kMargin_px, "(g) Trajectories from above",
               "lines: moving; faint: static; boxes: this frame");
  draw_caption(canvas, layout.paths.side, side_left, "(h) Trajectories from the side", note);
  return canvas;
}

}  // namespace kinetrace::figure

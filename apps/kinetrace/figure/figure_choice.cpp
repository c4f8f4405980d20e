#include "figure/figure_choice.hpp"

#include <algorithm>
#include <cmath>

namespace kinetrace::figure {
namespace {

bool is_cut_off(const PixelBox& box, int width_px, int height_px) {
  return box.x0 <= 0 || box.y0 <= 0 || (width_px > 0 && box.x1 >= width_px) || (height_px > 0 && box.y1 >= height_px);
}

double weight_of(const recording::ObjectRow& row, int width_px, int height_px) {
  if (row.status != BodyStatus::kTracked) {
    return 0.0;
  }
  if (!row.moving) {
    return 0.1;
  }
  return is_cut_off(row.mask_px, width_px, height_px) ? 0.5 : 1.0;
}

std::size_t tracked_frames(const TrackRows& track) {
  return static_cast<std::size_t>(std::count_if(track.rows.begin(), track.rows.end(),
                                                [](const auto* row) { return row->status == BodyStatus::kTracked; }));
}

}  // namespace

std::int64_t choose_frame(const FigureRun& run, int width_px, int height_px) {
  const auto& objects = run.run().objects;
  const auto& camera = run.run().camera;
  std::int64_t best_frame = camera[camera.size() / 2].frame;
  double best = 0.0;
  for (std::size_t i = 0; i < objects.size();) {
    const std::int64_t frame = objects[i].frame;
    double score = 0.0;
    for (; i < objects.size() && objects[i].frame == frame; ++i) {
      score += weight_of(objects[i], width_px, height_px) * objects[i].pixel_height;
    }
    if (score > best && run.camera_at(frame) != nullptr) {
      best = score;
      best_frame = frame;
    }
  }
  return best_frame;
}

std::int64_t choose_frame_of(const TrackRows& track) {
  const recording::ObjectRow* best = track.rows.front();
  for (const recording::ObjectRow* row : track.rows) {
    const bool is_better = row->status == BodyStatus::kTracked &&
                           (best->status != BodyStatus::kTracked || row->pixel_height > best->pixel_height);
    best = is_better ? row : best;
  }
  return best->frame;
}

std::optional<std::uint32_t> choose_object(const FigureRun& run, std::int64_t frame, int width_px, int height_px) {
  std::optional<std::uint32_t> choice;
  double best = 0.0;
  for (const recording::ObjectRow& row : run.objects_at(frame)) {
    const auto frames = static_cast<double>(tracked_frames(*run.track(row.track_id)));
    const double score = weight_of(row, width_px, height_px) * row.pixel_height * std::sqrt(row.point_count * frames);
    if (score > best) {
      best = score;
      choice = row.track_id;
    }
  }
  if (choice) {
    return choice;
  }
  std::size_t most = 0;
  for (const TrackRows& track : run.tracks()) {
    if (const std::size_t frames = tracked_frames(track); frames > most) {
      most = frames;
      choice = track.track_id;
    }
  }
  return choice;
}

}  // namespace kinetrace::figure

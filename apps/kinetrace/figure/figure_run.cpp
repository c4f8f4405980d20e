#include "figure/figure_run.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <utility>

#include "kinetrace/core/detections.hpp"

namespace kinetrace::figure {
namespace {

bool is_moving(const TrackRows& track) {
  const auto moving = static_cast<std::size_t>(
      std::count_if(track.rows.begin(), track.rows.end(), [](const recording::ObjectRow* row) { return row->moving; }));
  return moving >= 3 && moving * 5 >= track.rows.size();
}

}  // namespace

Result<FigureRun> FigureRun::open(const std::filesystem::path& directory) {
  Result<recording::Run> run = recording::read_run(directory);
  if (!run) {
    return Unexpected(run.error());
  }
  return from(std::move(*run));
}

Result<FigureRun> FigureRun::from(recording::Run run) {
  if (run.camera.empty()) {
    return fail(ErrorCode::kBadFormat,
                (run.directory / "camera.tum").string() + ": the run has no frame; there is nothing to draw");
  }
  FigureRun figure;
  figure.run_ = std::move(run);
  std::map<std::uint32_t, TrackRows> tracks;
  for (const recording::ObjectRow& row : figure.run_.objects) {
    TrackRows& track = tracks[row.track_id];
    track.track_id = row.track_id;
    track.class_id = row.class_id;
    track.rows.push_back(&row);
  }
  // One name in all pictures, that of the summary: a region found by motion may be recognised later.
  for (recording::ObjectRow& row : figure.run_.objects) {
    row.class_id = tracks[row.track_id].class_id;
  }
  for (auto& [id, track] : tracks) {
    track.moving = is_moving(track);
    figure.tracks_.push_back(std::move(track));
  }
  return figure;
}

const recording::CameraRow* FigureRun::camera_at(std::int64_t frame) const noexcept {
  const auto place = std::lower_bound(run_.camera.begin(), run_.camera.end(), frame,
                                      [](const recording::CameraRow& row, std::int64_t f) { return row.frame < f; });
  return place != run_.camera.end() && place->frame == frame ? &*place : nullptr;
}

std::span<const recording::ObjectRow> FigureRun::objects_at(std::int64_t frame) const noexcept {
  const auto begin = std::lower_bound(run_.objects.begin(), run_.objects.end(), frame,
                                      [](const recording::ObjectRow& row, std::int64_t f) { return row.frame < f; });
  auto end = begin;
  while (end != run_.objects.end() && end->frame == frame) {
    ++end;
  }
  return {begin, end};
}

const TrackRows* FigureRun::track(std::uint32_t track_id) const noexcept {
  const auto place = std::lower_bound(tracks_.begin(), tracks_.end(), track_id,
                                      [](const TrackRows& track, std::uint32_t id) { return track.track_id < id; });
  return place != tracks_.end() && place->track_id == track_id ? &*place : nullptr;
}

double FigureRun::seconds(std::int64_t timestamp_ns) const noexcept {
  return static_cast<double>(timestamp_ns - run_.camera.front().timestamp_ns) * 1e-9;
}

std::string class_name(std::uint16_t class_id) {
  switch (class_id) {
    case kVehicleClass: return "car";
    case kPedestrianClass: return "pedestrian";
    default: return "object";
  }
}

std::string track_name(std::uint16_t class_id, std::uint32_t track_id) {
  return class_name(class_id) + " " + std::to_string(track_id);
}

std::string with_unit(double value, int decimals, const char* unit) {
  std::array<char, 48> text{};
  std::snprintf(text.data(), text.size(), "%.*f %s", decimals, value, unit);
  return text.data();
}

}  // namespace kinetrace::figure

#include "synthetic_run.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <stdlib.h>
#include <utility>

namespace kinetrace::recording {

TemporaryFolder::TemporaryFolder() {
  std::string name = (std::filesystem::temp_directory_path() / "kinetrace_recording_XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) {
    throw std::runtime_error("cannot create " + name);
  }
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

RecordingConfig recording_config(const std::filesystem::path& directory) {
  RecordingConfig config;
  config.directory = directory;
  config.geometry = SyntheticRun::geometry();
  return config;
}

SyntheticRun::SyntheticRun(SyntheticRunConfig config)
    : config_(std::move(config)),
      body_data_(config_.objects.size() + 1),
      labels_(static_cast<std::size_t>(kWidth) * kHeight) {}

StereoGeometry SyntheticRun::geometry() {
  return {.fx_px = 200.0,
          .fy_px = 210.0,
          .cx_px = 161.25,
          .cy_px = 58.5,
          .baseline_m = 0.5,
          .width_px = kWidth,
          .height_px = kHeight};
}

Se3 SyntheticRun::T_world_cam(int frame) {
  const double swing = std::sin(0.05 * frame);
  return {so3_exp({0.0, 0.2 * swing, 0.0}), {0.4 * swing, -0.2 * swing, 6.0 * swing}};
}

Se3 SyntheticRun::T_world_obj(std::uint32_t track_id, int frame) {
  const double id = track_id % 7;
  return {so3_exp({0.02, 0.3 * id + 0.02 * frame, -0.01}), {id - 3.0, 0.5, 15.0 + id + 0.4 * frame}};
}

Box3 SyntheticRun::box(std::uint32_t track_id, int frame) {
  Box3 box;
  box.center_m = T_world_obj(track_id, frame).translation + Eigen::Vector3d(0.1, -0.2, 0.3);
  box.size_m = {4.0, 1.5, 1.8};
  box.yaw_rad = 0.3 * (track_id % 7) + 0.02 * frame;
  return box;
}

PixelBox SyntheticRun::mask_box(std::size_t slot, int frame) {
  const int x = 10 + static_cast<int>(slot % 6) * 50 + frame % 5;
  const int y = 20 + static_cast<int>(slot / 6) * 9;
  return {x, y, x + 12, y + 7};
}

Eigen::Vector3f SyntheticRun::point_position(std::uint32_t track_id, std::uint32_t point_id) {
  const auto spread = [point_id](std::uint32_t salt) {
    return static_cast<float>((point_id * 2654435761U + salt * 40503U) >> 16 & 0xffU) / 255.F - 0.5F;
  };
  const Eigen::Vector3f unit(spread(1), spread(2), spread(3));
  return track_id == 0 ? Eigen::Vector3f(20.F * unit.x(), 4.F * unit.y(), 60.F + 20.F * unit.z())
                       : Eigen::Vector3f(2.F * unit);
}

void SyntheticRun::estimate(int frame, FrameEstimate& out, std::vector<ObjectResult>& objects) const {
  objects.clear();
  out.frame_index = frame;
  out.timestamp_ns = timestamp_ns(frame);
  out.camera.status = BodyStatus::kTracked;
  out.camera.T_world_cam = T_world_cam(frame);
  for (std::size_t slot = 0; slot < config_.objects.size(); ++slot) {
    const SyntheticObject& truth = config_.objects[slot];
    if (frame < truth.first_frame || frame > truth.last_frame) {
      continue;
    }
    ObjectResult object;
    object.track_id = truth.track_id;
    object.class_id = truth.class_id;
    object.label = static_cast<std::uint8_t>(slot % kMaxObjects + 1);
    object.status = truth.status;
    object.moving = true;
    object.T_world_obj = T_world_obj(truth.track_id, frame);
    object.T_obj_cam = object.T_world_obj.inverse() * T_world_cam(frame);
    object.covariance = Matrix6d::Identity() * 1e-4;
    object.velocity_mps = {0.0, 0.0, 4.0};
    object.box = box(truth.track_id, frame);
    object.heading_rad = object.box.yaw_rad;
    object.box_px = mask_box(slot % kMaxObjects, frame);
    object.point_count = truth.points;
    object.inliers = truth.points;
    objects.push_back(object);
  }
  out.objects = objects;
}

void SyntheticRun::renew_points(int frame, bool is_last) {
  for (Body& body : body_data_) {
    body.retired.clear();
  }
  const auto body_of = [&](const LivePoint& point) -> std::size_t {
    for (std::size_t i = 0; i < config_.objects.size(); ++i) {
      if (point.track_id == config_.objects[i].track_id) {
        return i + 1;
      }
    }
    return 0;
  };
  std::erase_if(live_, [&](const LivePoint& point) {
    const std::size_t body = body_of(point);
    const int end = body == 0 ? point.born + config_.point_life_frames
                              : std::min(config_.frames, config_.objects[body - 1].last_frame + 1);
    if (!is_last && frame < end) {
      return false;
    }
    const int seen = std::min(end, config_.frames) - point.born;
    body_data_[body].retired.push_back({.id = point.id,
                                        .position_m = point_position(point.track_id, point.id),
                                        .reprojection_error_px = 0.25F,
                                        .observations = static_cast<std::uint16_t>(seen),
                                        .intensity = static_cast<std::uint8_t>(point.id % 256)});
    return true;
  });
  if (frame >= config_.frames) {
    return;
  }
  const auto born = [&](std::uint32_t track_id, int count) {
    for (int i = 0; i < count; ++i) {
      live_.push_back({track_id, next_point_id_++, frame});
    }
  };
  const auto background = std::count_if(live_.begin(), live_.end(), [](const LivePoint& p) { return p.track_id == 0; });
  born(0, config_.background_points - static_cast<int>(background));
  for (const SyntheticObject& object : config_.objects) {
    if (object.first_frame == frame) {
      born(object.track_id, object.points);
    }
  }
}

void SyntheticRun::fill_bodies(int frame, bool with_observations) {
  bodies_.clear();
  for (std::size_t i = 0; i < body_data_.size(); ++i) {
    Body& body = body_data_[i];
    const std::uint32_t track_id = i == 0 ? 0 : config_.objects[i - 1].track_id;
    const Se3 T_cam_body = T_world_cam(frame).inverse() * (track_id == 0 ? Se3{} : T_world_obj(track_id, frame));
    body.observations.clear();
    for (const LivePoint& point : live_) {
      if (with_observations && point.track_id == track_id) {
        const Eigen::Vector3d uvr = geometry().project(T_cam_body * point_position(track_id, point.id).cast<double>());
        body.observations.push_back(
            {point.id, static_cast<float>(uvr.x()), static_cast<float>(uvr.y()), static_cast<float>(uvr.z())});
      }
    }
    BodyGeometry& reported = bodies_.emplace_back();
    reported.track_id = track_id;
    reported.status = BodyStatus::kTracked;
    reported.observations = body.observations;
    reported.retired = body.retired;
  }
}

void SyntheticRun::paint_labels(int frame) {
  std::fill(labels_.begin(), labels_.end(), kBackgroundLabel);
  tracks_.clear();
  for (std::size_t slot = 0; slot < config_.objects.size(); ++slot) {
    const SyntheticObject& object = config_.objects[slot];
    if (frame < object.first_frame || frame > object.last_frame) {
      continue;
    }
    Track track;
    track.id = object.track_id;
    track.slot = static_cast<std::uint8_t>(slot % kMaxObjects);
    track.class_id = object.class_id;
    track.state = TrackState::kConfirmed;
    track.box_px = mask_box(slot % kMaxObjects, frame);
    for (int y = track.box_px.y0; y < track.box_px.y1; ++y) {
      std::uint8_t* row = labels_.data() + static_cast<std::ptrdiff_t>(y) * kWidth;
      std::fill_n(row + track.box_px.x0, track.box_px.width(), track.label());
    }
    tracks_.push_back(track);
  }
}

const FrameResult* SyntheticRun::next() {
  const int frame = step_++;
  const bool draining = frame >= config_.frames;
  const int finalised = frame - config_.settling_lag;
  if (finalised >= config_.frames || config_.frames == 0) {
    return nullptr;
  }
  const int newest = std::min(frame, config_.frames - 1);
  estimate(newest, result_.newest, newest_objects_);
  result_.has_finalised = finalised >= 0;
  if (result_.has_finalised) {
    estimate(finalised, result_.finalised, finalised_objects_);
  }
  renew_points(frame, finalised == config_.frames - 1);
  fill_bodies(newest, !draining);
  result_.bodies = bodies_;
  paint_labels(newest);
  result_.tracks = tracks_;
  result_.left_labels = draining ? LabelView{} : LabelView{labels_.data(), kWidth, kHeight, kWidth};
  name_ = config_.name_prefix + std::to_string(newest);
  result_.pair.left = {labels_.data(), kWidth, kHeight, kWidth};
  result_.pair.name = config_.name_prefix.empty() ? std::string_view{} : std::string_view(name_);
  return &result_;
}

Status SyntheticRun::play(RunRecorder& recorder) {
  while (const FrameResult* result = next()) {
    if (Status recorded = recorder.record(*result); !recorded) {
      return recorded;
    }
  }
  return {};
}

Status record_all(const RecordingConfig& recording, const SyntheticRunConfig& run) {
  RecorderFixture fixture(recording);
  if (!fixture.recorder) {
    return Unexpected(fixture.recorder.error());
  }
  if (Status played = SyntheticRun(run).play(*fixture.recorder); !played) {
    return played;
  }
  RunSummary summary;
  summary.frames = run.frames;
  return fixture.recorder->finish(summary);
}

}  // namespace kinetrace::recording

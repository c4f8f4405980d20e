#include "truth_run.hpp"

#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

#include "kinetrace/recording/run_recorder.hpp"
#include "output/recording_writer.hpp"
#include "scenes/scenes.hpp"

namespace kinetrace::test {
namespace {

using simulator::ObjectTruth;
using simulator::SimulatedFrame;

void expect_done(const Status& status) {
  if (!status) {
    throw std::runtime_error(status.error().message);
  }
}

simulator::StereoSimulator small_street() {
  simulator::Scene scene = simulator::make_scene("street").value();
  scene.rig = simulator::resized(scene.rig, 700, std::nullopt);
  return simulator::StereoSimulator::create(std::move(scene), {}).value();
}

ObjectResult true_result(const ObjectTruth& truth, const Se3& T_run_world) {
  ObjectResult object;
  object.track_id = static_cast<std::uint32_t>(truth.id);
  object.class_id = truth.class_id;
  object.status = BodyStatus::kTracked;
  object.moving = truth.moving;
  object.T_world_obj = T_run_world * truth.T_world_obj;
  object.velocity_mps = T_run_world.rotation * truth.velocity_mps;
  const Eigen::Vector3d forward = object.T_world_obj.rotation.col(0);
  object.heading_rad = std::atan2(-forward.z(), forward.x());
  object.box = {object.T_world_obj * Eigen::Vector3d(0.0, -truth.size_lhw_m.y() / 2.0, 0.0), truth.size_lhw_m,
                object.heading_rad};
  object.box_px = truth.box_px;
  return object;
}

/// One frame's truth as the pipeline would report it. Objects are labelled with their ids.
struct TrueFrame {
  std::vector<ObjectResult> objects;
  std::vector<Track> tracks;
  std::vector<std::uint8_t> labels;
  FrameResult result;

  TrueFrame(const SimulatedFrame& frame, const Se3& T_run_world) {
    for (const ObjectTruth& truth : frame.objects) {
      if (truth.visible_px > 0) {
        objects.push_back(true_result(truth, T_run_world));
        tracks.push_back({.id = static_cast<std::uint32_t>(truth.id),
                          .slot = static_cast<std::uint8_t>(truth.id - 1),
                          .class_id = truth.class_id,
                          .state = TrackState::kConfirmed,
                          .box_px = truth.box_px,
                          .area_px = truth.visible_px});
      }
    }
    const auto& instances = frame.instances[0];
    for (const std::uint16_t value : instances.pixels()) {
      labels.push_back(static_cast<std::uint8_t>(value % 1000));
    }
    result.newest.frame_index = frame.index;
    result.newest.timestamp_ns = frame.timestamp_ns;
    result.newest.camera.status = BodyStatus::kTracked;
    result.newest.camera.T_world_cam = T_run_world * frame.T_world_cam;
    result.newest.objects = objects;
    result.has_finalised = true;
    result.finalised = result.newest;
    result.tracks = tracks;
    result.left_labels = {labels.data(), instances.width(), instances.height(), instances.width()};
  }
};

}  // namespace

TruthRun::TruthRun(const std::filesystem::path& folder) : truth_(folder / "truth") {
  simulator::StereoSimulator simulator = small_street();
  geometry_ = simulator.scene().rig;
  auto writer = simulator::RecordingWriter::create({folder, true, {}}, simulator).value();
  for (int i = 0; i < kFrames; ++i) {
    frames_.push_back(simulator.frame(i));
    expect_done(writer.write(frames_.back()));
  }
  expect_done(writer.finish());
  recording_ = writer.drive();
}

void TruthRun::record(const std::filesystem::path& run_folder, int first_frame, std::int64_t later_ns) const {
  recording::RecordingConfig config;
  config.directory = run_folder;
  config.geometry = geometry_;
  config.points = false;
  config.colmap = false;
  Arena arena(recording::RunRecorder::required_bytes(config));
  recording::RunRecorder recorder = recording::RunRecorder::create(config, arena).value();
  const Se3 T_run_world = frames_[static_cast<std::size_t>(first_frame)].T_world_cam.inverse();
  for (int i = first_frame; i < kFrames; ++i) {
    TrueFrame frame(frames_[static_cast<std::size_t>(i)], T_run_world);
    frame.result.newest.timestamp_ns += later_ns;
    frame.result.finalised.timestamp_ns += later_ns;
    expect_done(recorder.record(frame.result));
  }
  recording::RunSummary summary;
  summary.frames = static_cast<std::uint64_t>(kFrames - first_frame);
  expect_done(recorder.finish(summary));
}

}  // namespace kinetrace::test

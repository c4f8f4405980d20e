#include "clip_run.hpp"

#include <cstdlib>
#include <fstream>

#include <gtest/gtest.h>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/hal/file_stereo_camera.hpp"
#include "kinetrace/hal/rectifier.hpp"
#include "kinetrace/pipeline/pipeline.hpp"

namespace kinetrace::test {
namespace {

void keep(const FrameResult& result, ClipRun& run) {
  run.counters = result.counters;
  if (!result.has_settled) {
    return;
  }
  run.frames.push_back(result.settled.frame_index);
  run.camera.push_back(result.settled.camera);
  for (const ObjectResult& object : result.settled.objects) {
    run.objects[object.track_id].push_back({result.settled.frame_index, object, result.settled.camera.T_world_cam});
  }
}

}  // namespace

std::optional<std::filesystem::path> data_folder() {
  const char* named = std::getenv("KINETRACE_DATA");
  const std::filesystem::path folder = named != nullptr ? named : KINETRACE_DEFAULT_DATA;
  if (!std::filesystem::is_directory(folder)) {
    return std::nullopt;
  }
  return folder;
}

ClipRun run_clip(const hal::DatasetSpec& spec, pipeline::PipelineConfig config) {
  ClipRun run;
  Result<hal::Dataset> dataset = hal::open_dataset(spec);
  if (!dataset) {
    ADD_FAILURE() << dataset.error().message;
    return run;
  }
  const hal::RigCalibration calibration = dataset->calibration;
  Arena arena(96U << 20U);
  Result<hal::Rectifier> rectifier = hal::Rectifier::create(calibration, {}, arena);
  Result<hal::FileStereoCamera> camera = hal::FileStereoCamera::create(std::move(*dataset), {}, arena);
  if (!rectifier || !camera || !camera->open() || !camera->start()) {
    ADD_FAILURE() << "camera or rectifier: "
                  << (!rectifier ? rectifier.error().message
                      : !camera  ? camera.error().message
                                 : "open");
    return run;
  }
  Result<pipeline::Pipeline> pipeline = pipeline::Pipeline::create(config, rectifier->geometry(), arena);
  if (!pipeline) {
    ADD_FAILURE() << pipeline.error().message;
    return run;
  }
  for (;;) {
    const Result<StereoFrame> frame = camera->next(std::chrono::milliseconds(1000));
    if (!frame) {
      EXPECT_EQ(frame.error().code, ErrorCode::kEndOfStream) << frame.error().message;
      break;
    }
    const Result<RectifiedPair> pair = rectifier->process(*frame);
    if (!pair) {
      ADD_FAILURE() << pair.error().message;
      return run;
    }
    const Result<const FrameResult*> result = pipeline->process(*pair);
    if (!result) {
      ADD_FAILURE() << result.error().message;
      return run;
    }
    keep(**result, run);
  }
  while (const FrameResult* result = pipeline->drain()) {
    keep(*result, run);
  }
  return run;
}

double distance_m(const ObjectRow& row) {
  return (row.object.T_world_obj.translation - row.T_world_cam.translation).norm();
}

std::vector<Se3> read_kitti_poses(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::vector<Se3> poses;
  std::array<double, 12> n;
  while (file >> n[0]) {
    for (std::size_t i = 1; i < n.size(); ++i) {
      file >> n[i];
    }
    Se3 pose;
    pose.rotation << n[0], n[1], n[2], n[4], n[5], n[6], n[8], n[9], n[10];
    pose.translation << n[3], n[7], n[11];
    poses.push_back(pose);
  }
  return poses;
}

double translation_drift(const std::vector<Se3>& truth, const std::vector<Se3>& estimate, double length_m) {
  double sum = 0.0;
  int count = 0;
  for (std::size_t first = 0; first < truth.size(); ++first) {
    double travelled_m = 0.0;
    for (std::size_t last = first + 1; last < truth.size() && last < estimate.size(); ++last) {
      travelled_m += (truth[last].translation - truth[last - 1].translation).norm();
      if (travelled_m >= length_m) {
        const Se3 moved_true = truth[first].inverse() * truth[last];
        const Se3 moved = estimate[first].inverse() * estimate[last];
        sum += (moved_true.inverse() * moved).translation.norm() / travelled_m;
        ++count;
        break;
      }
    }
  }
  return count > 0 ? sum / count : 1.0;
}

}  // namespace kinetrace::test

#include "clip_run.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <fstream>
#include <limits>

#include <gtest/gtest.h>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/hal/file_stereo_camera.hpp"
#include "kinetrace/hal/rectifier.hpp"
#include "kinetrace/pipeline/pipeline.hpp"

namespace kinetrace::test {
namespace {

void keep(const FrameResult& result, ClipRun& run) {
  run.counters = result.counters;
  if (!result.has_finalised) {
    return;
  }
  run.frames.push_back(result.finalised.frame_index);
  run.camera.push_back(result.finalised.camera);
  for (const ObjectResult& object : result.finalised.objects) {
    run.objects[object.track_id].push_back({result.finalised.frame_index, object, result.finalised.camera.T_world_cam});
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

std::vector<Se3> shifted(const std::vector<Se3>& path, double offset_frames) {
  std::vector<Se3> out;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const double at = std::clamp(static_cast<double>(i) + offset_frames, 0.0, static_cast<double>(path.size() - 1));
    const auto before = std::min(static_cast<std::size_t>(at), path.size() - 2);
    out.push_back(interpolate(path[before], path[before + 1], at - static_cast<double>(before)));
  }
  return out;
}

double time_offset_frames(const std::vector<Se3>& truth, const std::vector<Se3>& estimate) {
  const auto step = [](const std::vector<Se3>& path, std::size_t i) {
    return so3_log(path[i].rotation.transpose() * path[i + 1].rotation);
  };
  double best = 0.0;
  double best_cost = std::numeric_limits<double>::infinity();
  for (double offset = -1.0; offset <= 1.0; offset += 0.05) {
    const std::vector<Se3> moved = shifted(truth, offset);
    double cost = 0.0;
    for (std::size_t i = 2; i + 3 < estimate.size(); ++i) {
      cost += (step(moved, i) - step(estimate, i)).squaredNorm();
    }
    if (cost < best_cost) {
      best_cost = cost;
      best = offset;
    }
  }
  return best;
}

namespace {

/// Mean of `error(true motion, estimated motion)` over the distance, for all sub-paths of `length_m`.
template <typename Error>
double mean_over_sub_paths(const std::vector<Se3>& truth, const std::vector<Se3>& estimate, double length_m,
                           Error error) {
  double sum = 0.0;
  int count = 0;
  for (std::size_t first = 0; first < truth.size(); ++first) {
    double travelled_m = 0.0;
    for (std::size_t last = first + 1; last < truth.size() && last < estimate.size(); ++last) {
      travelled_m += (truth[last].translation - truth[last - 1].translation).norm();
      if (travelled_m >= length_m) {
        sum += error(truth[first].inverse() * truth[last], estimate[first].inverse() * estimate[last]) / travelled_m;
        ++count;
        break;
      }
    }
  }
  return count > 0 ? sum / count : 1.0;
}

}  // namespace

double translation_drift(const std::vector<Se3>& truth, const std::vector<Se3>& estimate, double length_m) {
  return mean_over_sub_paths(truth, estimate, length_m, [](const Se3& moved_true, const Se3& moved) {
    return (moved_true.inverse() * moved).translation.norm();
  });
}

double length_error(const std::vector<Se3>& truth, const std::vector<Se3>& estimate, double length_m) {
  return mean_over_sub_paths(truth, estimate, length_m, [](const Se3& moved_true, const Se3& moved) {
    return std::abs(moved.translation.norm() - moved_true.translation.norm());
  });
}

}  // namespace kinetrace::test

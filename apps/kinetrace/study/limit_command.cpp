#include "study/limit_command.hpp"

#include <algorithm>
#include <cstdio>

#include <CLI/CLI.hpp>

#include "cli/failure.hpp"
#include "cli/interrupt.hpp"
#include "cli/messages.hpp"
#include "cli/option_checks.hpp"
#include "cli/shared_options.hpp"
#include "config/app_config.hpp"
#include "kinetrace/hal/rectifier.hpp"
#include "study/limit_summary.hpp"
#include "study/pixel_noise.hpp"
#include "study/study_play.hpp"
#include "study/study_recording.hpp"
#include "study/visible_points.hpp"

namespace kinetrace::app {
namespace {

struct LimitOptions {
  std::vector<std::filesystem::path> recordings;  ///< Folders made by kinetrace-simulate.
  std::string masks = "detections";
  std::vector<double> noise_px;  ///< Of positions and of disparities; empty: as measured.
  ConfigSource config;
  std::filesystem::path out;
  bool quiet = false;
};

/// Measurements during playback of one recording.
struct Measurement {
  StudyErrors errors;
  VisiblePoints visible;
  PixelNoiseMeter noise;

  Status add(const FrameResult& result, StudyTruth& truth) {
    if (Status added = errors.add(result); !added || result.pair.left.empty()) {
      return added;
    }
    const std::int64_t frame = result.newest.frame_index;
    const std::vector<evaluation::LocatedObject> objects = truth.objects(frame);
    const std::optional<Se3> T_world_cam = truth.camera_pose(frame);
    if (objects.empty() || !T_world_cam) {
      return {};
    }
    const Result<TrueImages> images = truth.images(frame);
    if (!images) {
      return Unexpected(images.error());
    }
    visible.add(frame, result.newest.timestamp_ns, *T_world_cam, objects, *images);
    noise.add(result, *T_world_cam, objects, *images);
    return {};
  }
};

std::vector<LimitRow> limit_rows(const Measurement& measured, const StereoGeometry& geometry, const PixelNoise& noise,
                                 const MotionPrior& prior) {
  struct Bound {
    PoseBound bound;
    std::size_t points = 0;
  };
  std::map<std::pair<std::uint32_t, std::int64_t>, Bound> bounds;  // By object and frame.
  for (const auto& [id, body] : measured.visible.bodies()) {
    const std::vector<PoseBound> of_body = pose_bounds(body, geometry, noise, prior);
    for (std::size_t k = 0; k < of_body.size(); ++k) {
      // Motion is measured between consecutive frames only.
      PoseBound bound = of_body[k];
      if (k == 0 || body.views[k - 1].frame + 1 != body.views[k].frame) {
        bound.motion_m = bound.motion_deg = 0.0;
      }
      bounds[{id, body.views[k].frame}] = {bound, body.views[k].points};
    }
  }
  std::vector<LimitRow> rows;
  for (const StudyRow& row : measured.errors.rows()) {
    if (const auto found = bounds.find({row.object_id, row.frame}); found != bounds.end()) {
      rows.push_back({row, found->second.bound, found->second.points});
    }
  }
  return rows;
}

Outcome<LimitRun> measure(const LimitOptions& options, const std::filesystem::path& path) {
  Outcome<StudyRecording> recording = open_study_recording(path, options.masks);
  if (!recording) {
    return Unexpected(recording.error());
  }
  Result<AppConfig> config = load_config(options.config, recording->segmentation);
  if (!config) {
    return failure(config.error());
  }
  const auto geometry = hal::Rectifier::rectified_geometry(recording->dataset.calibration, config->rectification);
  if (!geometry) {
    return failure(geometry.error());
  }
  Measurement measured{StudyErrors(recording->truth), VisiblePoints(*geometry), PixelNoiseMeter(*geometry)};
  const Status played = play_recording(
      recording->dataset, *config, [&](const FrameResult& result) { return measured.add(result, recording->truth); });
  if (!played) {
    return failure(played.error());
  }
  std::optional<PixelNoise> noise = measured.noise.noise();
  if (!options.noise_px.empty()) {
    noise = PixelNoise{options.noise_px[0], options.noise_px[1]};
  }
  if (!noise) {
    return Unexpected(Failure{ExitCode::kBadData, path.string() + ": no point of a moving rigid object was measured; "
                                                                  "simulate another scene, or give --noise"});
  }
  return LimitRun{path.string(), *noise, limit_rows(measured, *geometry, *noise, config->pipeline.trajectory.motion)};
}

int study_limit(const LimitOptions& options) {
  if (const Status there = check_study_recordings(options.recordings); !there) {
    return report(to_failure(there.error()));
  }
  for (const Status& ready : {make_study_folder(options.out, options.recordings), check_limit_places(options.out)}) {
    if (!ready) {
      return report({ExitCode::kCannotCreate, ready.error().message});
    }
  }
  catch_interrupts();
  std::vector<LimitRun> runs;
  for (const std::filesystem::path& path : options.recordings) {
    const Outcome<LimitRun> run = measure(options, path);
    if (!run) {
      return report(run.error());
    }
    if (interrupted_by() != 0) {
      return kSignalBase + interrupted_by();
    }
    if (!options.quiet) {
      std::printf("%s: noise of a place %.3f px, of a disparity %.3f px\n", run->recording.c_str(),
                  run->noise.position_px, run->noise.disparity_px);
    }
    runs.push_back(*run);
  }
  for (const auto& write : {write_limit_csv, write_limit_plot}) {
    if (const Status written = write(runs, options.out); !written) {
      return report(to_failure(written.error()));
    }
  }
  std::fputs(limit_tables(runs).c_str(), stdout);
  return static_cast<int>(ExitCode::kOk);
}

void add_options(CLI::App& limit, LimitOptions& options) {
  limit.add_option("RECORDING", options.recordings, "Folders made by kinetrace-simulate")->required();
  limit.add_option("--out", options.out, "Folder for limit.csv and limit.png")->type_name("DIR")->required();
  limit.add_option("--masks", options.masks, "detections: masks like those of a network; instances: exact masks")
      ->check(CLI::IsMember({"detections", "instances"}))
      ->capture_default_str();
  limit
      .add_option("--noise", options.noise_px,
                  "Standard deviations of a point's place and of its disparity, to compare two versions by the same "
                  "bound; default: as measured")
      ->type_name("PX,PX")
      ->delimiter(',')
      ->expected(2)
      ->check(number_within(1e-3, 10.0));
  add_config_options(limit, options.config);
  limit.add_flag("--quiet", options.quiet, "Does not print the noise of the points");
}

}  // namespace

Action add_limit(CLI::App& command) {
  return bind_options(command, add_options, study_limit);
}

}  // namespace kinetrace::app

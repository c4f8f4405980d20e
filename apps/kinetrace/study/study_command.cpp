#include <algorithm>
#include <cstdio>
#include <memory>
#include <set>

#include <CLI/CLI.hpp>

#include "cli/commands.hpp"
#include "cli/failure.hpp"
#include "cli/interrupt.hpp"
#include "cli/messages.hpp"
#include "cli/shared_options.hpp"
#include "config/app_config.hpp"
#include "study/limit_command.hpp"
#include "study/study_play.hpp"
#include "study/study_recording.hpp"
#include "study/study_summary.hpp"

namespace kinetrace::app {
namespace {

namespace fs = std::filesystem;

struct StudyOptions {
  std::vector<std::filesystem::path> recordings;  ///< Folders made by kinetrace-simulate.
  std::vector<int> windows{1, 5, 10, 20};         ///< Frames of an object's window.
  std::string masks = "detections";               ///< Or "instances": exact masks.
  ConfigSource config;
  std::filesystem::path out;
  bool quiet = false;
};

/// One configuration of the study.
struct Variant {
  std::string name;
  int window_frames = 0;  ///< 0: the unchanged configuration.
};

std::vector<Variant> variants(const StudyOptions& options) {
  std::vector<Variant> all;
  for (const int window : std::set<int>(options.windows.begin(), options.windows.end())) {
    all.push_back({std::to_string(window), window});
  }
  all.push_back({"default", 0});
  return all;
}

// Every frame is a keyframe, so that a window consists of frames and not of keyframes, which gather the measurements of
// frames between them. The background is the same in all variants.
void apply(const Variant& variant, const StudyOptions& options, pipeline::PipelineConfig& config) {
  if (variant.window_frames > 0) {
    const int longest = *std::max_element(options.windows.begin(), options.windows.end());
    config.background.window_frames = std::max(config.background.window_frames, longest);
    config.object.window_frames = variant.window_frames;
    config.object.keyframe_motion_px = 0.0;
  }
}

Outcome<StudyRun> run_variant(const StudyOptions& options, StudyRecording& recording, const Variant& variant) {
  Result<AppConfig> config = load_config(options.config, recording.segmentation);
  if (!config) {
    return failure(config.error());
  }
  apply(variant, options, config->pipeline);
  if (const Status valid = config->validate(); !valid) {
    return failure(valid.error());
  }
  StudyErrors errors(recording.truth);
  const Status played =
      play_recording(recording.dataset, *config, [&](const FrameResult& result) { return errors.add(result); });
  if (!played) {
    return failure(played.error());
  }
  return StudyRun{recording.name, variant.name, errors.rows()};
}

Outcome<std::vector<StudyRun>> run_all(const StudyOptions& options) {
  std::vector<StudyRun> runs;
  for (const fs::path& path : options.recordings) {
    Outcome<StudyRecording> recording = open_study_recording(path, options.masks);
    if (!recording) {
      return Unexpected(recording.error());
    }
    for (const Variant& variant : variants(options)) {
      if (!options.quiet) {
        std::fprintf(stderr, "%s, window %s\n", recording->name.c_str(), variant.name.c_str());
      }
      Outcome<StudyRun> run = run_variant(options, *recording, variant);
      if (!run) {
        return Unexpected(run.error());
      }
      runs.push_back(std::move(*run));
      if (interrupted_by() != 0) {
        return runs;
      }
    }
  }
  return runs;
}

bool has_no_results(const std::vector<StudyRun>& runs) {
  return std::all_of(runs.begin(), runs.end(), [](const StudyRun& run) { return run.rows.empty(); });
}

int study_object_size(const StudyOptions& options) {
  if (const Status there = check_study_recordings(options.recordings); !there) {
    return report(to_failure(there.error()));
  }
  for (const Status& ready : {make_study_folder(options.out, options.recordings), check_study_places(options.out)}) {
    if (!ready) {
      return report({ExitCode::kCannotCreate, ready.error().message});
    }
  }
  catch_interrupts();
  const Outcome<std::vector<StudyRun>> runs = run_all(options);
  if (!runs) {
    return report(runs.error());
  }
  if (interrupted_by() != 0) {
    return kSignalBase + interrupted_by();
  }
  if (has_no_results(*runs)) {
    return report({ExitCode::kBadData, "no rigid object moves in these recordings; simulate the scene receding"});
  }
  for (const auto& write : {write_study_csv, write_study_plot}) {
    if (const Status written = write(*runs, options.out); !written) {
      return report(to_failure(written.error()));
    }
  }
  std::fputs(study_tables(*runs).c_str(), stdout);
  return static_cast<int>(ExitCode::kOk);
}

void add_options(CLI::App& object_size, StudyOptions& options) {
  object_size
      .add_option("RECORDING", options.recordings,
                  "Folders made by kinetrace-simulate, best of the scene `receding` with several seeds")
      ->required();
  object_size.add_option("--out", options.out, "Folder for frames.csv, bins.csv and object_size.png")
      ->type_name("DIR")
      ->required();
  object_size.add_option("--windows", options.windows, "Frames of an object's window; 1 is single-frame stereo")
      ->delimiter(',')
      ->check(CLI::Range(1, 32))
      ->capture_default_str();
  object_size.add_option("--masks", options.masks, "detections: masks like those of a network; instances: exact masks")
      ->check(CLI::IsMember({"detections", "instances"}))
      ->capture_default_str();
  add_config_options(object_size, options.config);
  object_size.add_flag("--quiet", options.quiet, "Prints no progress");
}

}  // namespace

Action add_study(CLI::App& command) {
  command.require_subcommand(1);
  CLI::App& object_size = *command.add_subcommand(
      "object-size", "Errors of objects by size in the image and by number of frames of the reconstruction");
  const Action study_size = bind_options(object_size, add_options, study_object_size);
  CLI::App& limit = *command.add_subcommand("limit", "Errors of objects relative to their Cramer-Rao bound");
  const Action study_limit = add_limit(limit);
  // The commands of the parser are gone when the action runs.
  const auto chosen = std::make_shared<Action>();
  object_size.callback([chosen, study_size] { *chosen = study_size; });
  limit.callback([chosen, study_limit] { *chosen = study_limit; });
  return [chosen] { return (*chosen)(); };
}

}  // namespace kinetrace::app

#include "refine.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <memory>
#include <thread>

#include "camera_path.hpp"
#include "camera_refinement.hpp"
#include "cli/interrupt.hpp"
#include "cli/messages.hpp"
#include "figure/figure_images.hpp"
#include "kinetrace/recording/held_folder.hpp"
#include "kinetrace/recording/run_recorder.hpp"
#include "object_gaps.hpp"
#include "object_history.hpp"
#include "object_joining.hpp"
#include "object_refinement.hpp"
#include "refine_progress.hpp"
#include "refined_run.hpp"
#include "run_details.hpp"
#include "run_scale.hpp"

namespace kinetrace::batch {
namespace {

namespace fs = std::filesystem;
using app::ExitCode;
using app::failure;
using app::Failure;
using app::Outcome;
using app::RefineOptions;

Unexpected<Failure> cannot_create(const Error& why) {
  return Unexpected(Failure{ExitCode::kCannotCreate, why.message});
}

Outcome<recording::Run> read(const RefineOptions& options) {
  std::error_code error;
  if (fs::equivalent(options.run, options.out, error) ||
      fs::weakly_canonical(options.run, error) == fs::weakly_canonical(options.out, error)) {
    return Unexpected(Failure{ExitCode::kUsage,
                              options.out.string() + ": is the run itself; name another folder for the refined one"});
  }
  if (const Status usable = recording::RunRecorder::check_folder(options.out); !usable) {
    return cannot_create(usable.error());
  }
  Result<recording::Run> run = recording::read_run(options.run);
  if (!run) {
    return failure(run.error());
  }
  if (run->camera.empty() || run->rectified.width_px == 0) {
    return Unexpected(Failure{ExitCode::kBadData, options.run.string() +
                                                      ": has no frame, or does not say what its cameras are; give the "
                                                      "folder of another run"});
  }
  if (const Status readable = check_details(*run); !readable) {
    return failure(readable.error());
  }
  return std::move(*run);
}

/// Reader of the recording's images; empty if they are not wanted, or, with a note, not where the run says. Errors:
/// those of opening a recording that was given as an option.
Outcome<PairReader> image_reader(const recording::Run& run, const RefineOptions& options,
                                 std::vector<std::string>& notes) {
  if (!options.images) {
    return PairReader{};
  }
  Result<figure::RecordedImages> opened = figure::RecordedImages::open(run, options.dataset);
  if (!opened && !options.dataset.empty()) {
    return failure(opened.error());
  }
  if (!opened) {
    notes.push_back("points were not measured again, and places that the camera saw twice not looked for: " +
                    opened.error().message +
                    "; --dataset LAYOUT:PATH says where the recording lies, --no-images does without it");
    return PairReader{};
  }
  const auto images = std::make_shared<figure::RecordedImages>(std::move(*opened));
  return PairReader([images](std::int64_t frame) { return images->pair(frame); });
}

/// Not for a refined run, which has been measured already.
Result<MeasuredBackground> measure(const recording::Run& run, const PairReader& read, const AdjustmentOptions& options,
                                   RefineProgress& progress) {
  const bool is_refined = std::any_of(run.dataset_fields.begin(), run.dataset_fields.end(),
                                      [](const auto& field) { return field.first == "refined_from"; });
  if (!read || is_refined) {
    return MeasuredBackground{};
  }
  return measure_background(run, read, {options.keep_going, [&](std::size_t rows) { progress.measured(rows); }});
}

/// Joins split tracks, and fills gaps and starts of each object's track.
Status complete_lives(const recording::Run& run, RefinedRun& refined) {
  const std::vector<Se3>& T_world_cam = refined.camera.T_world_cam;
  const auto masks_px = object_masks(run);
  if (!masks_px) {
    return Unexpected(masks_px.error());
  }
  for (auto& [track_id, object] : refined.objects) {
    if (const auto masks = masks_px->find(track_id); masks != masks_px->end()) {
      fill_birth(run, T_world_cam, masks->second, object);
    }
  }
  refined.joined_into = join_tracks(refined.objects);
  for (auto& [track_id, object] : refined.objects) {
    fill_gaps(run, T_world_cam, object);
  }
  return {};
}

/// A reference may rescale `run`.
Outcome<RefinedRun> refine(recording::Run& run, const RefineOptions& asked, RefineProgress& progress) {
  const AdjustmentOptions options{.threads = std::max(1, static_cast<int>(std::thread::hardware_concurrency())),
                                  .keep_going = [] { return app::interrupted_by() == 0; }};
  const Outcome<HoldPath> hold = read_reference(run, asked.reference, options);
  if (!hold) {
    return Unexpected(hold.error());
  }
  RefinedRun refined;
  const Outcome<PairReader> read = image_reader(run, asked, refined.notes);
  if (!read) {
    return Unexpected(read.error());
  }
  Result<MeasuredBackground> measured = measure(run, *read, options, progress);
  if (!measured) {
    return failure(measured.error());
  }
  refined.measured = std::move(*measured);
  if (const std::size_t missing = refined.measured.frames_without_images; missing > 0) {
    refined.notes.push_back("the points of " + std::to_string(missing) +
                            " frames were not measured again: the recording has no images of them any more");
  }
  Result<RefinedCamera> camera =
      refine_camera(run, refined.measured, options, [&](std::size_t rows) { progress.camera(rows); });
  if (!camera) {
    return failure(camera.error());
  }
  refined.camera = std::move(*camera);
  if (refined.camera.points.empty()) {
    refined.notes.push_back(
        "the camera's path was not refined: observations.bin has no point of the background that several frames of the "
        "run show");
  }
  Outcome<PathCorrection> correction = correct_path(
      run, refined.measured, {asked.loops ? *read : PairReader{}, progress}, *hold, options, refined.camera);
  if (!correction) {
    return Unexpected(correction.error());
  }
  refined.path = std::move(*correction);
  scale_run(refined.path.scale, run);
  Result<std::map<std::uint32_t, ObjectHistory>> histories = object_histories(run, refined.measured);
  if (!histories) {
    return failure(histories.error());
  }
  std::size_t rows_done = 0;
  for (const auto& [track_id, history] : *histories) {
    Result<RefinedObject> object = refine_object(run, refined.camera.T_world_cam, history, options);
    if (!object) {
      return failure(object.error());
    }
    refined.objects.emplace(track_id, std::move(*object));
    rows_done += history.rows.size();
    progress.objects(rows_done);
  }
  if (app::interrupted_by() == 0) {
    if (const Status completed = complete_lives(run, refined); !completed) {
      return failure(completed.error());
    }
  }
  return refined;
}

/// `signal`: that stopped the refinement; 0: none.
recording::RunSummary summary_of(const recording::Run& run, const RefinedRun& refined, const RefineOptions& options,
                                 int signal) {
  recording::RunSummary summary;
  summary.version = KINETRACE_VERSION;
  summary.config_json = run.config_json;
  summary.dataset = run.dataset_fields;
  std::erase_if(summary.dataset, [](const auto& field) {
    return field.first == "refined_from" || field.first == "loops" || field.first == "reference";
  });
  summary.dataset.emplace_back("refined_from", options.run.string());
  summary.dataset.emplace_back("loops", std::to_string(refined.path.loops));
  if (!options.reference.source.empty()) {
    summary.dataset.emplace_back("reference", options.reference.source);
  }
  summary.warnings = run.notes;
  summary.warnings.insert(summary.warnings.end(), refined.notes.begin(), refined.notes.end());
  if (signal != 0) {
    summary.exit_status = app::kSignalBase + signal;
  }
  return summary;
}

Outcome<int> carry_out(const RefineOptions& options) {
  Outcome<recording::Run> run = read(options);
  if (!run) {
    return Unexpected(run.error());
  }
  for (const std::string& note : run->notes) {
    app::print_warning(note);
  }
  app::catch_interrupts();
  Result<recording::HeldFolder> folder = recording::HeldFolder::take(options.out);
  if (!folder) {
    return cannot_create(folder.error());
  }
  RefineProgress progress(!options.quiet, run->camera.size(), run->objects.size());
  Outcome<RefinedRun> refined = refine(*run, options, progress);
  if (!refined) {
    progress.clear();
    return Unexpected(refined.error());
  }
  const int signal = app::interrupted_by();
  if (signal != 0) {
    refined->notes.push_back("refinement was stopped by signal " + std::to_string(signal) +
                             "; what it did not reach is as the run had it");
  }
  const recording::RunSummary summary = summary_of(*run, *refined, options, signal);
  folder->release();
  const Status written =
      write_refined_run(*run, *refined, options.out, summary, [&](std::size_t rows) { progress.written(rows); });
  progress.clear();
  if (!written) {
    return failure(written.error());
  }
  if (options.json) {
    std::cout << std::ifstream(options.out / "run.json").rdbuf();
  } else if (!options.quiet) {
    std::printf("%s %zu frames and %zu objects into %s\n",
                summary.exit_status == 0 ? "Refined" : "Refined in part:", run->camera.size(), refined->objects.size(),
                options.out.c_str());
    for (const std::string& result : refined->path.results) {
      std::puts(result.c_str());
    }
  }
  for (const std::string& note : refined->notes) {
    app::print_warning(note);
  }
  return summary.exit_status;
}

}  // namespace

int refine_command(const RefineOptions& options) {
  const Outcome<int> outcome = carry_out(options);
  return outcome ? *outcome : app::report(outcome.error());
}

}  // namespace kinetrace::batch

#include "refine.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <thread>

#include "camera_refinement.hpp"
#include "cli/interrupt.hpp"
#include "cli/messages.hpp"
#include "figure/figure_images.hpp"
#include "loops/loop_closure.hpp"
#include "object_gaps.hpp"
#include "object_history.hpp"
#include "object_joining.hpp"
#include "object_refinement.hpp"
#include "refine_progress.hpp"
#include "refined_run.hpp"

namespace kinetrace::batch {
namespace {

namespace fs = std::filesystem;
using app::ExitCode;
using app::failure;
using app::Failure;
using app::Outcome;
using app::RefineOptions;

Outcome<recording::Run> read(const RefineOptions& options) {
  std::error_code error;
  if (fs::equivalent(options.run, options.out, error) ||
      fs::weakly_canonical(options.run, error) == fs::weakly_canonical(options.out, error)) {
    return Unexpected(Failure{ExitCode::kUsage,
                              options.out.string() + ": is the run itself; name another folder for the refined one"});
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
  return std::move(*run);
}

/// Joins what was cut, and fills what is missing of each object's life.
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
  refined.goes_on_as = join_tracks(refined.objects);
  for (auto& [track_id, object] : refined.objects) {
    fill_gaps(run, T_world_cam, object);
  }
  return {};
}

/// Closes the loops of the path. Errors: those of the recording's images, and of close_loops.
Result<ClosedLoops> find_loops(const recording::Run& run, const RefineOptions& options,
                               const AdjustmentOptions& adjustment, RefinedCamera& camera, RefineProgress& progress) {
  std::unique_ptr<figure::RecordedImages> images;
  const auto pair = [&](std::int64_t frame) -> Result<RectifiedPair> {
    if (images == nullptr) {
      Result<figure::RecordedImages> opened = figure::RecordedImages::open(run, options.dataset);
      if (!opened) {
        return Unexpected(opened.error());
      }
      images = std::make_unique<figure::RecordedImages>(std::move(*opened));
    }
    return images->pair(frame);
  };
  return close_loops(run, pair, adjustment, camera, [&](double part) { progress.loops(part); });
}

Result<RefinedRun> refine(const recording::Run& run, const RefineOptions& asked, RefineProgress& progress) {
  Result<std::map<std::uint32_t, ObjectHistory>> histories = object_histories(run);
  if (!histories) {
    return Unexpected(histories.error());
  }
  const AdjustmentOptions options{.threads = std::max(1, static_cast<int>(std::thread::hardware_concurrency())),
                                  .keep_going = [] { return app::interrupted_by() == 0; }};
  RefinedRun refined;
  Result<RefinedCamera> camera = refine_camera(run, options, [&](std::size_t rows) { progress.camera(rows); });
  if (!camera) {
    return Unexpected(camera.error());
  }
  refined.camera = std::move(*camera);
  if (asked.loops && options.keep_going()) {
    const Result<ClosedLoops> loops = find_loops(run, asked, options, refined.camera, progress);
    if (!loops && !asked.dataset.empty()) {
      return Unexpected(loops.error());
    }
    refined.loops = loops ? *loops : ClosedLoops{};
    if (!loops) {
      refined.notes.push_back("places that the camera saw twice were not looked for: " + loops.error().message +
                              "; --dataset LAYOUT:PATH says where the recording lies, --no-loops leaves them out");
    }
  }
  std::size_t rows_done = 0;
  for (const auto& [track_id, history] : *histories) {
    Result<RefinedObject> object = refine_object(run, refined.camera.T_world_cam, history, options);
    if (!object) {
      return Unexpected(object.error());
    }
    refined.objects.emplace(track_id, std::move(*object));
    rows_done += history.rows.size();
    progress.objects(rows_done);
  }
  if (app::interrupted_by() == 0) {
    if (const Status completed = complete_lives(run, refined); !completed) {
      return Unexpected(completed.error());
    }
  }
  return refined;
}

recording::RunSummary summary_of(const recording::Run& run, const RefinedRun& refined, const RefineOptions& options) {
  recording::RunSummary summary;
  summary.version = KINETRACE_VERSION;
  summary.config_json = run.config_json;
  summary.dataset = run.dataset_fields;
  std::erase_if(summary.dataset,
                [](const auto& field) { return field.first == "refined_from" || field.first == "loops"; });
  summary.dataset.emplace_back("refined_from", options.run.string());
  summary.dataset.emplace_back("loops", std::to_string(refined.loops.loops));
  summary.warnings = run.notes;
  summary.warnings.insert(summary.warnings.end(), refined.notes.begin(), refined.notes.end());
  if (const int signal = app::interrupted_by(); signal != 0) {
    summary.warnings.push_back("refinement was stopped by signal " + std::to_string(signal) +
                               "; what it did not reach is as the run had it");
    summary.exit_status = 128 + signal;
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
  RefineProgress progress(!options.quiet, run->camera.size(), run->objects.size());
  const Result<RefinedRun> refined = refine(*run, options, progress);
  if (!refined) {
    progress.clear();
    return failure(refined.error());
  }
  const recording::RunSummary summary = summary_of(*run, *refined, options);
  const Status written =
      write_refined_run(*run, *refined, options.out, summary, [&](std::size_t rows) { progress.written(rows); });
  progress.clear();
  if (!written) {
    return failure(written.error());
  }
  if (!options.quiet) {
    std::printf("Refined %zu frames and %zu objects into %s\n", run->camera.size(), refined->objects.size(),
                options.out.c_str());
    if (refined->loops.loops > 0) {
      std::printf("Closed %zu loops, which moved the path by up to %.2f m\n", refined->loops.loops,
                  refined->loops.moved_m);
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

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <yaml-cpp/yaml.h>

#include "cli/commands.hpp"
#include "cli/formatted.hpp"
#include "cli/messages.hpp"
#include "evaluation/evaluate_input.hpp"
#include "kinetrace/core/files.hpp"
#include "kinetrace/core/input_file.hpp"
#include "kinetrace/evaluation/condition.hpp"
#include "kinetrace/evaluation/evaluation.hpp"
#include "kinetrace/recording/common_times.hpp"

namespace kinetrace::app {
namespace {

namespace fs = std::filesystem;
using evaluation::Evaluation;

struct EvaluateOptions {
  std::filesystem::path run;
  std::filesystem::path against;  ///< Run to compare with; empty: none.
  std::filesystem::path truth;
  std::string truth_format;            ///< Empty: detected from the files.
  std::filesystem::path truth_camera;  ///< Camera poses for ground truth without them; empty: none.
  std::filesystem::path truth_masks;   ///< Folder of mask images; empty: the truth's own.
  std::filesystem::path body_camera;   ///< EuRoC's sensor.yaml; empty: found beside the truth.
  std::string association;             ///< "masks", "boxes", "centres", or empty for the best available.
  std::vector<std::string> fail_if;
  bool json = false;
  bool quiet = false;
};

constexpr double kGate_m = 3.0;

Result<std::vector<evaluation::Condition>> parse_conditions(const std::vector<std::string>& texts) {
  std::vector<evaluation::Condition> conditions;
  for (const std::string& text : texts) {
    Result<evaluation::Condition> condition = evaluation::parse_condition(text);
    if (!condition) {
      return Unexpected(condition.error());
    }
    conditions.push_back(std::move(*condition));
  }
  return conditions;
}

// EuRoC's sensor.yaml: T_BS, 16 numbers row by row.
Result<Se3> read_body_camera(const fs::path& path) {
  const Result<std::string> text = InputFile::read_whole(path);
  if (!text) {
    return Unexpected(text.error());
  }
  try {
    const auto values = YAML::Load(*text)["T_BS"]["data"].as<std::vector<double>>();
    if (values.size() == 16) {
      const Eigen::Matrix4d matrix = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(values.data());
      return Se3{matrix.topLeftCorner<3, 3>(), matrix.topRightCorner<3, 1>()}.orthonormalised();
    }
  } catch (const YAML::Exception&) {
    // Reported below: the library's message names neither file nor remedy.
  }
  return fail(ErrorCode::kBadFormat,
              path.string() + ": has no T_BS with 16 numbers; give EuRoC's sensor.yaml of the left camera");
}

// Defaults to the file beside EuRoC's ground truth.
fs::path find_body_camera(const EvaluateOptions& options) {
  if (!options.body_camera.empty()) {
    return options.body_camera;
  }
  const fs::path sensor = fs::path("cam0") / "sensor.yaml";
  const fs::path& truth = options.truth;
  for (const fs::path& path : {truth / "mav0" / sensor, truth / sensor, truth.parent_path() / sensor,
                               truth.parent_path().parent_path() / sensor}) {
    if (std::error_code error; fs::is_regular_file(path, error)) {
      return path;
    }
  }
  return {};
}

Result<evaluation::TruthSource> truth_source(const EvaluateOptions& options, const recording::Run& run) {
  evaluation::TruthSource source;
  source.path = options.truth;
  source.camera = options.truth_camera;
  source.masks = options.truth_masks;
  for (const auto& [name, format] : evaluation::kTruthFormats) {
    if (name == options.truth_format) {
      source.format = format;
    }
  }
  if (const fs::path body_camera = find_body_camera(options); !body_camera.empty()) {
    const Result<Se3> T_body_cam = read_body_camera(body_camera);
    if (!T_body_cam) {
      return Unexpected(T_body_cam.error());
    }
    source.T_body_cam = *T_body_cam;
  }
  for (const recording::CameraRow& row : run.camera) {
    source.frame_times_ns[row.frame] = row.timestamp_ns;
  }
  return source;
}

std::optional<evaluation::Association> wanted_association(const std::string& name) {
  using evaluation::Association;
  for (const Association association : {Association::kMasks, Association::kBoxes, Association::kCentres}) {
    if (name == to_string(association)) {
      return association;
    }
  }
  return std::nullopt;
}

fs::path recording_path(const recording::Run& run) {
  const fs::path path = run.dataset.substr(run.dataset.find(':') + 1);
  return path.has_filename() ? path : path.parent_path();
}

/// Whether a folder holds a drive of KITTI raw, as the simulator writes it.
bool holds_recording(const fs::path& folder) {
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    if (std::error_code none; fs::is_regular_file(entry->path() / "calib_cam_to_cam.txt", none)) {
      return true;
    }
  }
  return false;
}

// The simulator's truth lies beside its recording, and worlds of one scene look alike: the wrong one passes for a bad
// run. Empty if nothing shows that it is another one's.
std::string note_of_other_recording(const fs::path& truth, const recording::Run& run) {
  std::error_code error;
  const fs::path folder = fs::weakly_canonical(truth, error);
  const fs::path beside = folder.filename() == "truth" ? folder.parent_path() : folder;
  const fs::path recording = recording_path(run);
  const bool has_its_name =
      recording == "." || std::find(recording.begin(), recording.end(), beside.filename()) != recording.end();
  if (!run.dataset.starts_with("kitti-raw:") || has_its_name || !holds_recording(beside)) {
    return "";
  }
  return truth.string() + ": is the truth of " + beside.string() + ", the run is of " + run.dataset +
         "; unless they are the same recording, all figures are wrong";
}

// Other truth than the simulator's has no name. Stereo odometry drifts by 2 %, and by 10 % with a rather wrong scale.
std::string note_of_other_path(const evaluation::CameraMetrics& camera, const std::string& truth,
                               const recording::Run& run) {
  constexpr double kMaxDrift = 10.0;  // Per cent.
  if (!camera.t_rel_percent || *camera.t_rel_percent <= kMaxDrift) {
    return "";
  }
  return "the camera's path differs from " + truth + " by " + formatted("%.0f %%", *camera.t_rel_percent) +
         " of its length; unless the run failed, that is the truth of another recording than " + run.dataset;
}

Result<Evaluation> evaluate(const EvaluateOptions& options, const recording::Run& run) {
  const Result<evaluation::TruthSource> source = truth_source(options, run);
  if (!source) {
    return Unexpected(source.error());
  }
  const Result<evaluation::Truth> truth = evaluation::read_truth(*source);
  if (!truth) {
    return Unexpected(truth.error());
  }
  Result<EvaluationInput> input =
      match_up(run, *truth, source->time_tolerance_ns, wanted_association(options.association), kGate_m);
  if (!input) {
    return Unexpected(input.error());
  }
  Evaluation evaluation;
  evaluation.notes = run.notes;
  evaluation.notes.insert(evaluation.notes.end(), input->notes.begin(), input->notes.end());
  if (const std::string note = note_of_other_recording(options.truth, run);
      truth->format == evaluation::TruthFormat::kSimulator && !note.empty()) {
    evaluation.notes.push_back(note);
  }
  evaluation.run = run.directory.string();
  evaluation.truth = options.truth.string();
  evaluation.truth_format = to_string(truth->format);
  evaluation.camera = evaluation::evaluate_camera(input->camera);
  if (std::string note = note_of_other_path(evaluation.camera, evaluation.truth, run); !note.empty()) {
    evaluation.notes.push_back(std::move(note));
  }
  evaluation.camera_rotation_deg = input->camera_rotation_deg;
  evaluation.association = input->association;
  evaluation.object_config.truth_is_complete = truth->is_complete;
  if (truth->has_objects) {
    evaluation.objects = evaluation::evaluate_objects(input->objects, evaluation.object_config);
  }
  evaluation.masks = std::move(input->masks);
  return evaluation;
}

/// The exit code after all conditions; each that holds or cannot be checked is reported.
int check_conditions(const std::vector<evaluation::Condition>& conditions, const std::string& json) {
  int code = 0;
  for (const evaluation::Condition& condition : conditions) {
    const Result<evaluation::ConditionOutcome> outcome = evaluation::check(condition, json);
    if (!outcome) {
      return report(to_failure(outcome.error()));
    }
    if (outcome->holds) {
      char value[32];
      std::snprintf(value, sizeof value, "%.6g", outcome->value);
      code = report({ExitCode::kConditionHolds, condition.text + ": " + condition.path + " is " + value});
    }
  }
  return code;
}

/// Evaluates a run and writes the result into its folder.
Result<Evaluation> measure(const EvaluateOptions& options, const recording::Run& run) {
  Result<Evaluation> evaluation = evaluate(options, run);
  if (!evaluation) {
    return evaluation;
  }
  for (const std::string& note : evaluation->notes) {
    print_warning(note);
  }
  if (const Status written = replace_file(run.directory / "evaluation.json", evaluation::evaluation_json(*evaluation));
      !written) {
    return Unexpected(written.error());
  }
  return evaluation;
}

bool is_below(const fs::path& path, const fs::path& folder) {
  return std::mismatch(path.begin(), path.end(), folder.begin(), folder.end()).second == folder.end();
}

/// What shows that two runs are of different recordings: other names, wherever the recordings lay, or few times in
/// common. Empty if nothing does; runs without a recording's name may be of any.
std::string recording_difference(const recording::Run& run, const recording::Run& against) {
  const fs::path here = recording_path(run);
  const fs::path there = recording_path(against);
  const bool is_named = !run.dataset.empty() && !against.dataset.empty();
  const bool has_same_name = here.filename() == there.filename() || is_below(here, there) || is_below(there, here);
  if (is_named && !has_same_name) {
    return "the recordings " + run.dataset + " and " + against.dataset;
  }
  if (is_named && run.sequence != against.sequence) {
    return "the sequences " + run.sequence + " and " + against.sequence;
  }
  std::vector<std::int64_t> times_ns;
  for (const recording::CameraRow& row : against.camera) {
    times_ns.push_back(row.timestamp_ns);
  }
  const recording::CommonTimes times = recording::common_times(run, std::move(times_ns));
  return times.are_most() ? ""
                          : "only " + std::to_string(times.common) + " of " + std::to_string(times.frames) +
                                " times of frames are in both";
}

/// The run, and the one to compare it with, if there is one.
Result<std::vector<recording::Run>> read_runs(const EvaluateOptions& options) {
  std::vector<recording::Run> runs;
  for (const fs::path& folder : {options.run, options.against}) {
    if (folder.empty()) {
      continue;
    }
    Result<recording::Run> run = recording::read_run(folder);
    if (!run) {
      return Unexpected(run.error());
    }
    runs.push_back(std::move(*run));
  }
  if (const std::string difference = runs.size() == 2 ? recording_difference(runs[0], runs[1]) : "";
      !difference.empty()) {
    return fail(ErrorCode::kBadFormat, options.run.string() + " and " + options.against.string() +
                                           ": are of different recordings (" + difference +
                                           "); --against takes another run of the same one");
  }
  return runs;
}

/// Warns if two runs cover different frames. Runs with equal numbers of frames may still differ in the true path.
void check_same_frames(const Evaluation& run, const Evaluation& against) {
  constexpr double kSame_m = 1e-6;
  if (run.camera.frames == against.camera.frames && std::abs(run.camera.path_m - against.camera.path_m) < kSame_m) {
    return;
  }
  std::array<char, 128> frames;
  std::snprintf(frames.data(), frames.size(), "%zu frames over %.1f m and %zu over %.1f m", run.camera.frames,
                run.camera.path_m, against.camera.frames, against.camera.path_m);
  print_warning(run.run + " and " + against.run + " are not of the same frames: " + frames.data() +
                "; their figures cannot be compared");
}

int evaluate_command(const EvaluateOptions& options) {
  const Result<std::vector<evaluation::Condition>> conditions = parse_conditions(options.fail_if);
  if (!conditions) {
    return report(to_failure(conditions.error()));
  }
  const Result<std::vector<recording::Run>> runs = read_runs(options);
  if (!runs) {
    return report(to_failure(runs.error()));
  }
  const Result<Evaluation> evaluation = measure(options, runs->front());
  if (!evaluation) {
    return report(to_failure(evaluation.error()));
  }
  const std::string json = evaluation::evaluation_json(*evaluation);
  std::string text = options.json ? json : evaluation::evaluation_table(*evaluation);
  if (!options.against.empty()) {
    const Result<Evaluation> against = measure(options, runs->back());
    if (!against) {
      return report(to_failure(against.error()));
    }
    check_same_frames(*evaluation, *against);
    text = evaluation::comparison_table(*evaluation, *against);
  }
  if (options.json || !options.quiet) {
    std::fputs(text.c_str(), stdout);
  }
  return check_conditions(*conditions, json);
}

void add_options(CLI::App& evaluate, EvaluateOptions& options) {
  evaluate.add_option("RUN", options.run, "Run folder")->required();
  evaluate.add_option("--truth", options.truth, "Folder or file with the truth")->type_name("PATH")->required();
  evaluate
      .add_option("--truth-format", options.truth_format,
                  "Format of the truth, where it is not evident: simulator, kitti-tracking, kitti-poses, tum or euroc")
      ->check(CLI::IsMember({"simulator", "kitti-tracking", "kitti-poses", "tum", "euroc"}));
  evaluate.add_option("--truth-camera", options.truth_camera, "Camera poses for truth that has only labels")
      ->type_name("FILE");
  evaluate.add_option("--truth-masks", options.truth_masks, "True masks of the left images, KITTI MOTS PNG")
      ->type_name("DIR");
  evaluate
      .add_option("--truth-body-camera", options.body_camera,
                  "For EuRoC: sensor.yaml of the left camera, where it is not beside the truth")
      ->type_name("FILE");
  evaluate
      .add_option("--association", options.association,
                  "Criterion to match tracks with objects: masks, boxes in the image, or centres in space; without it, "
                  "the first of these in both run and truth")
      ->check(CLI::IsMember({"masks", "boxes", "centres"}));
  evaluate
      .add_option("--fail-if", options.fail_if,
                  "Exit code 1 if the condition holds, such as 'camera.t_rel>1.0': names of evaluation.json joined by "
                  "dots, one of > >= < <= ==, a number. A name that does not exist is an error (64), and so is a "
                  "quantity that could not be measured (65). May be repeated")
      ->type_name("CONDITION")
      ->allow_extra_args(false);
  CLI::Option* against =
      evaluate
          .add_option("--against", options.against,
                      "Another run of the same recording: prints the main figures of both in one table, with their "
                      "ratios; writes its evaluation.json, too")
          ->type_name("RUN");
  evaluate.add_flag("--json", options.json, "Prints evaluation.json on standard output instead of the table")
      ->excludes(against);
  evaluate.add_flag("--quiet", options.quiet, "Prints nothing but errors and conditions that hold");
}

}  // namespace

Action add_evaluate(CLI::App& command) {
  return bind_options(command, add_options, evaluate_command);
}

}  // namespace kinetrace::app

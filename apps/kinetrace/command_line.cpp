#include "command_line.hpp"

#include <cstdio>

#include <CLI/CLI.hpp>

#include "board_profiles.hpp"
#include "command_errors.hpp"
#include "command_footer.hpp"
#include "command_reference.hpp"
#include "kinetrace/hal/dataset.hpp"
#include "kinetrace/hal/fault_injector.hpp"
#include "kinetrace/segmentation/config.hpp"
#include "network_command_line.hpp"

namespace kinetrace::app {
namespace {

void add_config_options(CLI::App& command, ConfigSource& source) {
  command.add_option("--board", source.board, "Begins with the settings for a board: those in config/boards")
      ->type_name("NAME");
  command.add_option("--config", source.file, "YAML file; `kinetrace config` prints one with all keys")
      ->type_name("FILE");
  command.add_option("--set", source.settings, "Sets one key, after the file; may be repeated")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
}

void add_source_options(CLI::App& command, SourceOptions& source) {
  CLI::Option_group& from = *command.add_option_group("Source", "Where frames come from: one of");
  CLI::Option* dataset =
      from.add_option("--dataset", source.dataset,
                      "A recording; LAYOUT is kitti-raw, kitti-odometry, kitti-tracking, euroc, cityscapes, folder or "
                      "container")
          ->type_name("LAYOUT:PATH");
  from.add_option("--camera", source.camera, "A camera file; config/cameras holds commented examples")
      ->type_name("FILE");
  from.require_option(1);
  // A camera file says these itself.
  command.add_option("--sequence", source.sequence, "Which sequence, where the path holds several")
      ->type_name("NAME")
      ->needs(dataset);
  command.add_option("--cameras", source.cameras, "Which pair of cameras, where the rig has both (gray or color)")
      ->check(CLI::IsMember({"gray", "color"}))
      ->needs(dataset);
  command.add_option("--loop", source.passes, "Plays the recording N times")
      ->type_name("N")
      ->needs(dataset)
      ->check(CLI::PositiveNumber);
  command
      .add_option("--fault", source.faults,
                  "For tests: KIND@FIRST[-LAST][%PERCENT][:VALUE],... with unplug, stuck, slow, drop, duplicate, "
                  "reorder, corrupt, desync, clock or size, by frame from 0; seed=N")
      ->type_name("SPEC");
}

void add_until_options(CLI::App& command, UntilOptions& until) {
  command.add_option("--frames", until.max_frames, "Stops after N frames of the camera or recording")
      ->type_name("N")
      ->check(CLI::PositiveNumber);
  command.add_option("--seconds", until.max_seconds, "Stops after so much time")
      ->type_name("S")
      ->check(CLI::Range(0.001, 1e9));
}

void add_raw_options(CLI::App& command, RawOutputOptions& raw, CLI::Option* out) {
  CLI::Option* container =
      command
          .add_flag("--container", raw.container, "Raw images go into one file after another instead of KITTI's layout")
          ->needs(out);
  command.add_option("--segment-mib", raw.segment_mib, "A container goes on in a new file at this size")
      ->type_name("MIB")
      ->needs(container)
      ->check(CLI::Range(1, 1 << 20))
      ->capture_default_str();
  command.add_option("--keep-free-mib", raw.keep_free_mib, "Raw recording stops before the disk has less space left")
      ->type_name("MIB")
      ->needs(out)
      ->check(CLI::Range(0, 1 << 30))
      ->capture_default_str();
}

void add_publish_option(CLI::App& command, std::string& publish) {
  command.add_option("--publish", publish, "Publishes results over DDS as this file says; config/dds holds examples")
      ->type_name("FILE");
}

void add_run(CLI::App& app, RunOptions& options, std::string& out, std::string& raw_out) {
  CLI::App& run =
      *app.add_subcommand("run", "Reconstructs trajectories from a recording or a camera into a run folder");
  add_source_options(run, options.source);
  run.add_option("--segmentation", options.segmentation,
                 "Where objects come from: motion (the default), none (they are not looked for), mask files (KITTI "
                 "MOTS PNG) as masks:LEFT_DIR[,RIGHT_DIR], a "
                 "neural network as onnx[:MODEL.yaml], or dds: masks that another process sends, see kinetrace masks")
      ->type_name("HOW");
  add_config_options(run, options.config);
  run.add_option("--out", out, "Run folder; made, or replaced if it is an earlier run's")->type_name("DIR")->required();
  run.add_flag("--images", options.images,
               "Also writes the rectified left images into the run folder: those that its COLMAP models are of");
  add_until_options(run, options.until);
  CLI::Option* raw =
      run.add_option("--record", raw_out, "Also records the raw images, into a new folder")->type_name("DIR");
  add_raw_options(run, options.raw, raw);
  add_publish_option(run, options.publish);
  run.add_flag("--json", options.json, "Prints run.json on standard output instead of the summary");
  run.add_flag("--quiet", options.quiet, "Prints nothing but warnings and errors");
  run.footer(kFooter);
}

void add_record(CLI::App& app, RecordOptions& options, std::string& raw_out) {
  CLI::App& record = *app.add_subcommand("record", "Records a camera's synchronised raw images, without processing");
  add_source_options(record, options.source);
  CLI::Option* out = record.add_option("--out", raw_out, "New folder")->type_name("DIR")->required();
  add_until_options(record, options.until);
  add_raw_options(record, options.raw, out);
  record.add_flag("--quiet", options.quiet, "Prints nothing but warnings and errors");
  record.footer(kFooter);
}

void add_doctor(CLI::App& app, DoctorOptions& options) {
  CLI::App& doctor = *app.add_subcommand(
      "doctor", "Checks cameras, timing, calibration, memory and DDS; says what to do about each failure");
  doctor.add_option("CAMERA", options.camera, "Camera file; without it, the devices of this machine are listed");
  doctor.add_option("--publish", options.publish, "The file that the run will publish by; without it, DDS by default");
  doctor.add_option("--seconds", options.seconds, "Watches the images for so long")
      ->type_name("S")
      ->check(CLI::Range(0.1, 3600.0))
      ->capture_default_str();
  add_config_options(doctor, options.config);
  doctor.footer(kFooter);
}

void add_bench(CLI::App& app, BenchOptions& options) {
  CLI::App& bench = *app.add_subcommand(
      "bench", "Times every stage on a recording, alone or against an earlier version; writes no run folder");
  bench.add_option("--dataset", options.source.dataset, "A recording, as for run")
      ->type_name("LAYOUT:PATH")
      ->required();
  bench.add_option("--sequence", options.source.sequence, "Sequence, where the path holds several");
  bench.add_option("--segmentation", options.segmentation, "Where objects come from, as for run")->type_name("HOW");
  add_config_options(bench, options.config);
  bench.add_option("--repeat", options.repeat, "Plays the recording this often")
      ->type_name("N")
      ->check(CLI::Range(1, 10'000))
      ->capture_default_str();
  bench.add_option("--out", options.out, "Writes the times as JSON, for --against")->type_name("FILE");
  bench.add_option("--against", options.against, "Shows what has changed since this file was written")
      ->type_name("FILE");
  bench.footer(kFooter);
}

void add_plan(CLI::App& app, PlanOptions& options, std::string& size) {
  CLI::App& plan = *app.add_subcommand("plan", "Prints who takes how much memory, and whether the budget holds it");
  add_config_options(plan, options.config);
  add_publish_option(plan, options.publish);
  plan.add_option("--size", size,
                  "Size of one eye's images; without it, the board's (board.image_width_px, ..._height_px)")
      ->type_name("WxH");
}

void add_study(CLI::App& app, StudyOptions& options, std::string& out) {
  CLI::App& study = *app.add_subcommand("study", "Measures how well the method does as conditions change");
  study.require_subcommand(1);
  CLI::App& object_size = *study.add_subcommand(
      "object-size", "Errors of objects by their size in the image and by the frames they are reconstructed from");
  object_size
      .add_option("RECORDING", options.recordings,
                  "Folders made by kinetrace-simulate, best of the scene `receding` with several seeds")
      ->required()
      ->check(CLI::ExistingDirectory);
  object_size.add_option("--out", out, "Folder for frames.csv, bins.csv and object_size.png")
      ->type_name("DIR")
      ->required();
  object_size.add_option("--windows", options.windows, "Frames of an object's window; 1 is single-frame stereo")
      ->delimiter(',')
      ->check(CLI::Range(1, 32))
      ->capture_default_str();
  object_size.add_option("--masks", options.masks, "detections: as a network gives them; instances: exact")
      ->check(CLI::IsMember({"detections", "instances"}))
      ->capture_default_str();
  add_config_options(object_size, options.config);
  object_size.add_flag("--quiet", options.quiet, "Does not say what is being run");
  study.footer(kFooter);
}

void add_show_config(CLI::App& app, ConfigOptions& options) {
  CLI::App& config = *app.add_subcommand("config", "Prints the whole configuration as commented YAML");
  add_config_options(config, options.config);
}

void add_evaluate(CLI::App& app, EvaluateOptions& options) {
  CLI::App& evaluate =
      *app.add_subcommand("evaluate", "Compares a run with ground truth; writes evaluation.json into the run folder");
  evaluate.add_option("RUN", options.run, "Run folder")->required();
  evaluate.add_option("--truth", options.truth, "Folder or file with the truth")->type_name("PATH")->required();
  evaluate
      .add_option("--truth-format", options.truth_format,
                  "What it is, where that cannot be seen: simulator, kitti-tracking, kitti-poses, tum or euroc")
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
                  "Tracks are matched with objects by masks, boxes in the image, or centres in space; without it, by "
                  "the first of these that run and truth both have")
      ->check(CLI::IsMember({"masks", "boxes", "centres"}));
  evaluate
      .add_option("--fail-if", options.fail_if,
                  "Exit code 1 if the condition holds, such as 'camera.t_rel>1.0': names of evaluation.json joined by "
                  "dots, one of > >= < <= ==, a number. What does not exist is an error (64), and so is what could "
                  "not be measured (65). May be repeated")
      ->type_name("CONDITION")
      ->allow_extra_args(false);
  evaluate.add_flag("--json", options.json, "Prints evaluation.json on standard output instead of the table");
  evaluate.add_flag("--quiet", options.quiet, "Prints nothing but errors and conditions that hold");
  evaluate.footer(kFooter);
}

void add_summary(CLI::App& app, SummaryOptions& options) {
  CLI::App& summary =
      *app.add_subcommand("summary", "Prints what a run found: the camera's path, and a table of objects");
  summary.add_option("RUN", options.run, "Run folder")->required();
  summary.add_flag("--json", options.json, "Prints the same as JSON");
  summary.footer(kFooter);
}

void add_figure(CLI::App& app, FigureOptions& options) {
  CLI::App& figure = *app.add_subcommand("figure", "Draws the result figure of a run as a PNG, 1600 pixels wide");
  figure.add_option("RUN", options.run, "Run folder")->required();
  figure.add_option("--frame", options.frame, "Which frame; without it, the one that shows most of the moving objects")
      ->type_name("N");
  figure
      .add_option("--object", options.object,
                  "Whose reconstruction; without it, of the object that shows best in the frame")
      ->type_name("ID");
  figure.add_option("--out", options.out, "PNG file; without it, figure.png in the run folder")->type_name("FILE");
  figure
      .add_option("--overlay", options.overlay,
                  "Also writes every frame into this folder, with masks, boxes, speeds and trails drawn in")
      ->type_name("DIR");
  figure
      .add_option("--film", options.film,
                  "The same, above the trajectories so far, 720 pixels wide: pictures of a film")
      ->type_name("DIR");
  figure.add_option("--dataset", options.dataset, "Where the recording lies now, if not where the run was made")
      ->type_name("LAYOUT:PATH");
  figure.add_flag("--quiet", options.quiet, "Prints nothing but warnings and errors");
  figure.footer(kFooter);
}

void add_segment(CLI::App& app, SegmentOptions& options) {
  CLI::App& segment =
      *app.add_subcommand("segment", "Tries a neural network on images: writes the masks it finds, and draws them");
  segment.add_option("IMAGES", options.images, "PNG, JPEG or PGM files, or folders of them")->required();
  segment
      .add_option("--model", options.model,
                  "YAML file that describes the network; without it, the one that comes with Kinetrace, which knows "
                  "simulated pictures only")
      ->type_name("MODEL.yaml");
  segment
      .add_option("--out", options.out, "Folder for masks/STEM.png (KITTI MOTS) and overlay/STEM.png; made if needed")
      ->type_name("DIR")
      ->required();
  segment.add_option("--threads", options.threads, "Threads that the network uses")
      ->check(CLI::Range(1, 16))
      ->capture_default_str();
  segment.add_flag("--quiet", options.quiet, "Prints nothing but warnings and errors");
}

void add_reference(CLI::App& app, std::string& form) {
  CLI::App& reference = *app.add_subcommand("reference", "Prints this command line as a manual page or for bash");
  reference.add_option("FORM", form, "man: a page for man(1); bash: completion, source <(kinetrace reference bash)")
      ->required()
      ->check(CLI::IsMember({"man", "bash"}));
}

// For completion: values of options that take others besides.
ValueHints value_hints() {
  ValueHints hints;
  for (const std::string_view layout : hal::layout_names()) {
    hints["--dataset"].push_back(std::string(layout) + ":");
  }
  for (const segmentation::SegmentationMode mode : segmentation::kSegmentationModes) {
    const bool takes_folders = mode == segmentation::SegmentationMode::kMasks;
    hints["--segmentation"].push_back(std::string(to_string(mode)) + (takes_folders ? ":" : ""));
  }
  for (const std::string_view kind : hal::fault_kind_names()) {
    hints["--fault"].push_back(std::string(kind) + "@");
  }
  for (const BoardProfile& profile : board_profiles()) {
    hints["--board"].emplace_back(profile.name);
  }
  return hints;
}

Outcome<PlanOptions> with_size(PlanOptions options, const std::string& size) {
  if (size.empty()) {
    return options;
  }
  char rest = 0;
  // NOLINTNEXTLINE(cert-err34-c): values beyond int's range are refused by the bounds below.
  const int fields = std::sscanf(size.c_str(), "%5dx%5d%c", &options.width_px, &options.height_px, &rest);
  if (fields != 2 || options.width_px < 64 || options.height_px < 64 || options.width_px > 8192 ||
      options.height_px > 8192) {
    return Unexpected(Failure{ExitCode::kUsage, "--size " + size + ": expected WIDTHxHEIGHT, 64 to 8192 pixels each"});
  }
  return options;
}

}  // namespace

Outcome<Command> parse_command_line(int argc, const char* const* argv) {
  CLI::App app(
      "Kinetrace: a stereo camera or recording in, metric 3-D trajectories of the camera and of every object out.",
      "kinetrace");
  app.set_version_flag("--version", std::string("kinetrace ") + KINETRACE_VERSION);
  app.require_subcommand(1);
  app.footer(kFooter);

  RunOptions run;
  RecordOptions record;
  DoctorOptions doctor;
  BenchOptions bench;
  PlanOptions plan;
  ConfigOptions config;
  EvaluateOptions evaluate;
  StudyOptions study;
  FigureOptions figure;
  KeysOptions keys;
  MonitorOptions monitor;
  MaskOptions masks;
  SegmentOptions segment;
  SummaryOptions summary;
  std::string out;
  std::string recording;
  std::string folders;
  std::string raw_out;
  std::string size;
  std::string form;
  add_run(app, run, out, raw_out);
  add_record(app, record, raw_out);
  add_doctor(app, doctor);
  add_bench(app, bench);
  add_plan(app, plan, size);
  add_show_config(app, config);
  add_evaluate(app, evaluate);
  add_study(app, study, out);
  add_summary(app, summary);
  add_figure(app, figure);
  add_keys(app, keys);
  add_monitor(app, monitor, recording);
  add_masks(app, masks, folders);
  add_segment(app, segment);
  add_reference(app, form);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) {
      app.exit(error);
      return NothingToDo{};
    }
    return Unexpected(Failure{ExitCode::kUsage, command_error(app, error)});
  }
  if (app.got_subcommand("run")) {
    run.out = out;
    run.raw.out = raw_out;
    return run;
  }
  if (app.got_subcommand("record")) {
    record.raw.out = raw_out;
    return record;
  }
  if (app.got_subcommand("doctor")) {
    return doctor;
  }
  if (app.got_subcommand("bench")) {
    return bench;
  }
  if (app.got_subcommand("plan")) {
    return with_size(plan, size);
  }
  if (app.got_subcommand("evaluate")) {
    return evaluate;
  }
  if (app.got_subcommand("summary")) {
    return summary;
  }
  if (app.got_subcommand("study")) {
    study.out = out;
    return study;
  }
  if (app.got_subcommand("monitor")) {
    monitor.record = recording;
    return monitor;
  }
  if (app.got_subcommand("masks")) {
    return with_folders(masks, folders);
  }
  if (app.got_subcommand("segment")) {
    return segment;
  }
  if (app.got_subcommand("reference")) {
    std::fputs((form == "man" ? manual_page(app) : bash_completion(app, value_hints())).c_str(), stdout);
    return NothingToDo{};
  }
  if (app.got_subcommand("figure")) {
    return figure;
  }
  if (app.got_subcommand("keys")) {
    return keys;
  }
  return config;
}

}  // namespace kinetrace::app

#include "options.hpp"

#include <cmath>
#include <cstdio>
#include <numbers>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "cli/command_errors.hpp"
#include "cli/command_reference.hpp"
#include "cli/option_checks.hpp"
#include "scenes/scenes.hpp"

namespace kinetrace::simulator {
namespace {

std::string scene_list() {
  std::string text = "Scenes:\n";
  for (const SceneEntry& entry : scenes()) {
    std::string name = entry.name;
    name.resize(20, ' ');
    text += "  " + name + entry.summary + "\n";
  }
  return text;
}

void add_recording(CLI::App& app, Options& options, std::string& out, std::string& degrade) {
  app.add_option("SCENE", options.scene, "Scene to simulate; see below")->required();
  app.add_option("--out", out,
                 "Folder for the sequence and its truth; made, or replaced if it is an earlier simulation")
      ->type_name("DIR")
      ->required();
  app.add_option("--frames", options.frames, "Number of frames; default: those of the scene")
      ->check(app::at_least_one());
  app.add_option("--seed", options.simulator.seed,
                 "Seed of the world: houses, trees, ground, sun, looks and kinds of vehicles, speed and "
                 "place of people and vehicles, heights of people, empty parking spots, noise")
      ->type_name("N")
      ->capture_default_str();
  app.add_option("--width", options.width_px, "Width of the rectified pictures; the field of view stays")
      ->check(CLI::Range(64, 4096));
  app.add_option("--height", options.height_px, "Height of the rectified pictures; crops or adds rows")
      ->check(CLI::Range(64, 4096));
  app.add_option("--rate", options.rate_hz, "Frames a second")->type_name("HZ")->check(app::number_within(0.5, 240.0));
  app.add_option("--degrade", degrade, "Degrades masks/detections_* like those of a network")
      ->check(CLI::IsMember({"on", "off"}))
      ->capture_default_str();
  app.add_option_function<double>(
         "--missing", [&options](double percent) { options.recording.degradation.miss_probability = 0.01 * percent; },
         "Share of objects missing from degraded masks; default: 5")
      ->type_name("PERCENT")
      ->check(app::number_within(0.0, 100.0));
}

void add_camera(CLI::App& app, Options& options, int& samples) {
  SensorSettings& sensor = options.simulator.sensor;
  app.add_option("--noise", sensor.noise_levels, "Sensor noise at half range, standard deviation in grey levels")
      ->type_name("SIGMA")
      ->capture_default_str();
  app.add_option("--gain", sensor.right_gain, "Sensitivity of the right camera relative to the left one")
      ->capture_default_str();
  app.add_option("--vignetting", sensor.vignetting, "Part of the light that is lost in the corners")
      ->capture_default_str();
  app.add_option("--blur", sensor.blur_px, "Blur of the lens, standard deviation in pixels")->capture_default_str();
  app.add_option("--shutter", options.simulator.shutter_ms, "Exposure time; above 0, motion blurs the image")
      ->type_name("MS")
      ->capture_default_str();
  app.add_flag("--distortion", options.simulator.distortion,
               "Raw pictures through distorted lenses, with the calibration to rectify them");
  app.add_option("--samples", samples, "Rays per pixel")->check(CLI::IsMember({1, 4, 9, 16}))->capture_default_str();
  app.add_option("--threads", options.simulator.threads, "Number of threads; the result does not depend on it")
      ->capture_default_str();
}

constexpr double kDegree_rad = std::numbers::pi / 180.0;

void add_rig_errors(CLI::App& app, RigErrors& errors) {
  CLI::Option_group& group = *app.add_option_group("Errors of the calibration",
                                                   "Deviations of the cameras from the calibration that is written");
  group
      .add_option(
          "--drift", errors.drift_mrad,
          "Slow drifting of the right camera's direction, and half as much of its principal point, milliradians")
      ->type_name("MRAD")
      ->capture_default_str();
  group
      .add_option_function<std::vector<double>>(
          "--turn",
          [&errors](const std::vector<double>& deg) {
            errors.turn_rad = kDegree_rad * Eigen::Vector3d(deg[0], deg[1], deg[2]);
          },
          "Rotation of the right camera about its x, y and z axes, degrees")
      ->type_name("PITCH,YAW,ROLL")
      ->delimiter(',')
      ->expected(3);
  group
      .add_option_function<std::vector<double>>(
          "--baseline",
          [&errors](const std::vector<double>& deg) {
            errors.baseline_rad = kDegree_rad * Eigen::Vector2d(deg[0], deg[1]);
          },
          "Direction of the baseline, down and forward, degrees")
      ->type_name("DOWN,FORWARD")
      ->delimiter(',')
      ->expected(2);
  group.add_option("--knock", errors.knock_s, "Time from which --turn and --baseline hold, seconds")
      ->type_name("S")
      ->check(app::number_within(0.0, 1e9));
  group
      .add_option_function<double>(
          "--focal", [&errors](double percent) { errors.focal = 0.01 * percent; },
          "Excess of both focal lengths, percent")
      ->type_name("PERCENT");
}

app::ValueHints value_hints() {
  app::ValueHints hints;
  for (const SceneEntry& entry : scenes()) {
    hints["SCENE"].emplace_back(entry.name);
  }
  return hints;
}

// Ends parsing here, as --help does, so that required options may be missing.
void add_reference(CLI::App& app) {
  const auto print = [&app](const std::string& form) {
    std::fputs((form == "man" ? app::manual_page(app) : app::bash_completion(app, value_hints())).c_str(), stdout);
    throw CLI::Success();
  };
  app.add_option_function<std::string>("--reference", print, "Prints this command line as a manual page or for bash")
      ->check(CLI::IsMember({"man", "bash"}))
      ->trigger_on_parse();
}

}  // namespace

app::Outcome<std::optional<Options>> parse_options(int argc, const char* const* argv) {
  CLI::App app("Simulates a stereo recording with exact truth: a KITTI raw drive, and DIR/truth beside it.",
               "kinetrace-simulate");
  app.set_version_flag("--version", std::string("kinetrace-simulate ") + KINETRACE_VERSION);
  app.footer(scene_list());
  Options options;
  std::string out;
  std::string degrade = "on";
  int samples = 4;
  add_recording(app, options, out, degrade);
  add_camera(app, options, samples);
  add_rig_errors(app, options.simulator.errors);
  app.add_flag("--quiet", options.quiet, "Prints nothing but errors");
  add_reference(app);
  app::refuse_missing_values(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) {
      app.exit(error);
      return std::nullopt;
    }
    return Unexpected(app::Failure{app::ExitCode::kUsage, app::command_error(app, error)});
  }
  options.recording.folder = out;
  options.recording.degrade = degrade == "on";
  options.simulator.samples_per_side = static_cast<int>(std::lround(std::sqrt(samples)));
  return std::optional(std::move(options));
}

}  // namespace kinetrace::simulator

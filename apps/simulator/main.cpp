// kinetrace-simulate: a scene in, a stereo recording with its truth out.
#include <algorithm>
#include <cstdio>
#include <exception>
#include <future>
#include <optional>
#include <string>
#include <utility>

#include "cli/progress.hpp"
#include "cli/standard_files.hpp"
#include "options.hpp"
#include "output/recording_writer.hpp"
#include "rendering/stereo_simulator.hpp"
#include "scenes/scenes.hpp"

namespace kinetrace::simulator {
namespace {

Result<StereoSimulator> make_simulator(Options& options) {
  Result<Scene> scene = make_scene(options.scene, options.simulator.seed);
  if (!scene) {
    return Unexpected(scene.error());
  }
  scene->rig = resized(scene->rig, options.width_px, options.height_px);
  scene->rate_hz = options.rate_hz.value_or(scene->rate_hz);
  scene->frames = options.frames.value_or(scene->frames);
  return StereoSimulator::create(std::move(*scene), options.simulator);
}

Status record(StereoSimulator& simulator, const Options& options) {
  Result<RecordingWriter> writer = RecordingWriter::create(options.recording, simulator);
  if (!writer) {
    return Unexpected(writer.error());
  }
  if (writer->replaced() && !options.quiet) {
    std::fprintf(stderr, "kinetrace-simulate: %s: replaces the simulated sequence that was there\n",
                 options.recording.folder.c_str());
  }
  const int frames = simulator.scene().frames;
  app::Progress progress(!options.quiet, frames);
  // A frame is written while the next one is rendered: parts of both occupy only one core.
  const std::launch when = options.simulator.threads > 1 ? std::launch::async : std::launch::deferred;
  std::future<Status> writing;
  const auto finish_writing = [&]() -> Status { return writing.valid() ? writing.get() : Status{}; };
  for (int i = 0; i < frames; ++i) {
    SimulatedFrame frame = simulator.frame(i);
    if (Status written = finish_writing(); !written) {
      progress.clear();
      return written;
    }
    const auto visible = [](const ObjectTruth& object) { return object.visible_px > 0; };
    progress.show(i + 1, static_cast<int>(std::count_if(frame.objects.begin(), frame.objects.end(), visible)));
    writing = std::async(when, [&writer, frame = std::move(frame)] { return writer->write(frame); });
  }
  progress.clear();
  if (Status written = finish_writing(); !written) {
    return written;
  }
  if (Status finished = writer->finish(); !finished) {
    return finished;
  }
  if (!options.quiet) {
    std::printf("%d frames in %s\ntruth in %s\n", frames, writer->drive().c_str(),
                (options.recording.folder / "truth").c_str());
  }
  return {};
}

int report(const app::Failure& failure) {
  std::fprintf(stderr, "kinetrace-simulate: error: %s\n", failure.message.c_str());
  return static_cast<int>(failure.code);
}

int carry_out(int argc, char** argv) {
  app::Outcome<std::optional<Options>> options = parse_options(argc, argv);
  if (!options) {
    return report(options.error());
  }
  if (!*options) {
    return 0;
  }
  Result<StereoSimulator> simulator = make_simulator(**options);
  if (!simulator) {
    return report(app::to_failure(simulator.error()));
  }
  const Status recorded = record(*simulator, **options);
  return recorded ? 0 : report(app::to_failure(recorded.error()));
}

int simulate(int argc, char** argv) {
  // The library reports errors as values, but an allocation may still throw.
  try {
    return carry_out(argc, argv);
  } catch (const std::exception& error) {
    return report({app::ExitCode::kInternal, error.what()});
  }
}

}  // namespace
}  // namespace kinetrace::simulator

int main(int argc, char** argv) {
  kinetrace::app::prepare_standard_files();
  const int exit_code = kinetrace::simulator::simulate(argc, argv);
  const std::optional<std::string> lost = kinetrace::app::output_failure();
  const int writing_failed = lost ? kinetrace::simulator::report({kinetrace::app::ExitCode::kIo, *lost}) : 0;
  return exit_code == 0 ? writing_failed : exit_code;
}

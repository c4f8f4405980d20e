// Times the stages on a recording, for one version of the program against another.
#include <cstdio>
#include <fstream>
#include <memory>
#include <optional>
#include <string>

#include "app_config.hpp"
#include "bench_report.hpp"
#include "camera_setup.hpp"
#include "commands.hpp"
#include "interrupt.hpp"
#include "kinetrace/core/cpu.hpp"
#include "kinetrace/core/files.hpp"
#include "kinetrace/hal/rectifier.hpp"
#include "messages.hpp"
#include "stage_clock.hpp"
#include "study_play.hpp"

namespace kinetrace::app {
namespace {

std::string processor_name() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    // x86 has the one, some ARM boards the other.
    for (const char* key : {"model name", "Model"}) {
      const std::size_t colon = line.find(": ");
      if (line.rfind(key, 0) == 0 && colon != std::string::npos) {
        return line.substr(colon + 2);
      }
    }
  }
  return "an unnamed processor";
}

Outcome<BenchReport> measure(const BenchOptions& options) {
  const Result<AppConfig> config = load_config(options.config, options.segmentation);
  if (!config) {
    return failure(config.error());
  }
  const Outcome<CameraSetup> setup = camera_setup(options.source);
  if (!setup) {
    return Unexpected(setup.error());
  }
  const auto geometry = hal::Rectifier::rectified_geometry(setup->calibration, config->rectification);
  if (!geometry) {
    return failure(geometry.error());
  }
  const auto clock = std::make_unique<StageClock>();
  catch_interrupts();
  int repeats = 0;
  for (; repeats < options.repeat && interrupted_by() == 0; ++repeats) {
    const Status played = play_recording(
        *setup->dataset, *config, [](const FrameResult&) { return Status{}; }, clock.get());
    if (!played) {
      return failure(played.error());
    }
  }
  return BenchReport{.version = KINETRACE_VERSION,
                     .processor = processor_name(),
                     .kernels = kernel_isa(),
                     .dataset = options.source.dataset,
                     .width_px = geometry->width_px,
                     .height_px = geometry->height_px,
                     .repeats = repeats,
                     .frame = clock->frame_time(),
                     .stages = clock->stage_times()};
}

}  // namespace

int bench_command(const BenchOptions& options) {
  // First, so that nobody waits for a comparison that cannot be made.
  std::optional<BenchReport> before;
  if (!options.against.empty()) {
    Result<BenchReport> read = read_bench_report(options.against);
    if (!read) {
      return app::report(to_failure(read.error()));
    }
    before = std::move(*read);
  }
  const Outcome<BenchReport> measured = measure(options);
  if (!measured) {
    return app::report(measured.error());
  }
  std::printf("%s", bench_table(*measured, before ? &*before : nullptr).c_str());
  if (!options.out.empty()) {
    if (const Status written = replace_file(options.out, bench_json(*measured)); !written) {
      return app::report(to_failure(written.error()));
    }
  }
  return 0;
}

}  // namespace kinetrace::app

// Times the stages on a recording, to compare versions of the program.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>

#include "camera/camera_setup.hpp"
#include "cli/commands.hpp"
#include "cli/interrupt.hpp"
#include "cli/messages.hpp"
#include "cli/shared_options.hpp"
#include "config/app_config.hpp"
#include "kinetrace/core/config_check.hpp"
#include "kinetrace/core/cpu.hpp"
#include "kinetrace/core/files.hpp"
#include "kinetrace/hal/rectifier.hpp"
#include "live/stage_clock.hpp"
#include "run/bench_report.hpp"
#include "study/study_play.hpp"

namespace kinetrace::app {
namespace {

struct BenchOptions {
  SourceOptions source;  ///< A recording.
  std::string segmentation;
  ConfigSource config;
  int repeat = 3;
  std::string out;      ///< JSON; empty: none.
  std::string against;  ///< Report of an earlier version; empty: no comparison.
};

std::string processor_name() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    // The first exists on x86, the second on some ARM boards.
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
  Result<AppConfig> config = load_config(options.config, options.segmentation);
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

Status check_place(const std::filesystem::path& out) {
  const FileKind kind{.name = "report of `kinetrace bench`", .is_of_kind = [](const std::filesystem::path& path) {
                        return read_bench_report(path).has_value();
                      }};
  return first_failure({check_replaceable(out), check_same_kind(out, kind)});
}

int bench_command(const BenchOptions& options) {
  // First, so that an unreadable or occupied report fails before the measurement.
  if (const Status place = options.out.empty() ? Status{} : check_place(options.out); !place) {
    return app::report(to_failure(place.error()));
  }
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

void add_options(CLI::App& bench, BenchOptions& options) {
  bench.add_option("--dataset", options.source.dataset, "A recording, as for run")
      ->type_name("LAYOUT:PATH")
      ->required();
  bench.add_option("--sequence", options.source.sequence, "Sequence, where the path holds several");
  bench.add_option("--segmentation", options.segmentation, "Source of objects, as for run")->type_name("HOW");
  add_config_options(bench, options.config);
  bench.add_option("--repeat", options.repeat, "Number of times that the recording is played")
      ->type_name("N")
      ->check(CLI::Range(1, 10'000))
      ->capture_default_str();
  bench.add_option("--out", options.out, "Writes the times as JSON, for --against")->type_name("FILE");
  bench.add_option("--against", options.against, "Shows changes since this file was written")->type_name("FILE");
}

}  // namespace

Action add_bench(CLI::App& command) {
  return bind_options(command, add_options, bench_command);
}

}  // namespace kinetrace::app

// The command line of kinetrace-simulate.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "cli/failure.hpp"
#include "output/recording_writer.hpp"
#include "rendering/stereo_simulator.hpp"

namespace kinetrace::simulator {

struct Options {
  std::string scene;
  std::optional<int> frames;
  std::optional<int> width_px;
  std::optional<int> height_px;
  std::optional<double> rate_hz;
  SimulatorSettings simulator;
  RecordingSettings recording;
  bool quiet = false;
};

/// None if --help, --version or --reference was printed. Errors: kUsage.
[[nodiscard]] app::Outcome<std::optional<Options>> parse_options(int argc, const char* const* argv);

}  // namespace kinetrace::simulator

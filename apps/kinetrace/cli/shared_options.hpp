// Options that several commands have.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

// NOLINTNEXTLINE(readability-identifier-naming): theirs.
namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace kinetrace::app {

/// Where a configuration comes from; later ones win: defaults, the board, the file, the settings in order.
struct ConfigSource {
  std::string board;                  ///< Name of a profile; empty: none.
  std::string file;                   ///< Empty: none.
  std::vector<std::string> settings;  ///< "key=value" each.
};

/// Where frames come from: a recording or a camera.
struct SourceOptions {
  std::string dataset;   ///< "LAYOUT:PATH"; empty: a camera.
  std::string sequence;  ///< Empty where the path holds only one.
  std::string cameras;   ///< "gray", "color", or empty for whichever there is.
  std::string camera;    ///< Camera file; empty: a recording.
  std::string faults;    ///< To be injected; empty: none.
  int passes = 1;        ///< Play the recording this often.
  /// For raw images alone: a calibration is neither asked for nor read where images can do without.
  bool uncalibrated = false;
};

/// When to stop; 0: at the end, or at a signal.
struct UntilOptions {
  int max_frames = 0;
  double max_seconds = 0.0;
};

/// Raw images onto the disk.
struct RawOutputOptions {
  std::filesystem::path out;  ///< Empty: none.
  bool container = false;     ///< Instead of KITTI's raw layout.
  int segment_mib = 512;      ///< A container goes on in a new file at this size.
  int keep_free_mib = 256;    ///< Recording stops before the disk has less.
};

/// --board, --config and --set.
void add_config_options(CLI::App& command, ConfigSource& source);
/// --dataset or --camera, and what belongs to either.
void add_source_options(CLI::App& command, SourceOptions& source);
/// --frames and --seconds.
void add_until_options(CLI::App& command, UntilOptions& until);
/// How raw images are stored; `out` is the option that asks for them.
void add_raw_options(CLI::App& command, RawOutputOptions& raw, CLI::Option* out);
/// --publish of what a run publishes.
void add_publish_option(CLI::App& command, std::string& publish);

}  // namespace kinetrace::app

// Options shared by several commands.
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

/// Sources of a configuration; later ones win: defaults, the board, the file, the settings in order.
struct ConfigSource {
  std::string board;                  ///< Name of a profile; empty: none.
  std::string file;                   ///< Empty: none.
  std::vector<std::string> settings;  ///< "key=value" each.
};

/// Source of frames: a recording or a camera.
struct SourceOptions {
  std::string dataset;   ///< "LAYOUT:PATH"; empty: a camera.
  std::string sequence;  ///< Empty if the path holds only one.
  std::string cameras;   ///< "gray", "color", or empty for the available ones.
  std::string camera;    ///< Camera file; empty: a recording.
  std::string faults;    ///< Faults to inject; empty: none.
  int passes = 1;        ///< Play the recording this often.
  /// For raw images alone: a calibration is neither required nor read.
  bool uncalibrated = false;
};

/// Limits of a run; 0: until the end or a signal.
struct UntilOptions {
  int max_frames = 0;
  double max_seconds = 0.0;
};

/// Recording of raw images.
struct RawOutputOptions {
  std::filesystem::path out;  ///< Empty: none.
  bool container = false;     ///< Instead of KITTI's raw layout.
  int segment_mib = 512;      ///< A container continues in a new file at this size.
  int keep_free_mib = 256;    ///< Recording stops before free space falls below this.
};

/// --board, --config and --set.
void add_config_options(CLI::App& command, ConfigSource& source);
/// --dataset or --camera, and their options.
void add_source_options(CLI::App& command, SourceOptions& source);
/// --frames and --seconds.
void add_until_options(CLI::App& command, UntilOptions& until);
/// Storage of raw images; `out` is the option that enables it.
void add_raw_options(CLI::App& command, RawOutputOptions& raw, CLI::Option* out);
/// --publish of commands that publish.
void add_publish_option(CLI::App& command, std::string& publish);

}  // namespace kinetrace::app

// What the user asked for.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "failure.hpp"

namespace kinetrace::app {

/// Where a configuration comes from; later ones win: defaults, the file, the settings in order.
struct ConfigSource {
  std::string file;                   ///< Empty: none.
  std::vector<std::string> settings;  ///< "key=value" each.
};

struct RunOptions {
  std::string dataset;       ///< "LAYOUT:PATH".
  std::string sequence;      ///< Empty where the path holds only one.
  std::string cameras;       ///< "gray", "color", or empty for whichever there is.
  std::string segmentation;  ///< "motion", "none", "masks:LEFT[,RIGHT]", or empty for the configured one.
  ConfigSource config;
  std::filesystem::path out;
  int max_frames = 0;  ///< Stop after so many; 0: all.
  int passes = 1;      ///< Play the recording this often.
  bool json = false;
  bool quiet = false;
};

struct PlanOptions {
  ConfigSource config;
  int width_px = 0;
  int height_px = 0;
};

struct ConfigOptions {
  ConfigSource config;
};

struct EvaluateOptions {
  std::filesystem::path run;
  std::filesystem::path truth;
  std::string truth_format;            ///< Empty: by what is there.
  std::filesystem::path truth_camera;  ///< Poses for truth that has none; empty: none.
  std::filesystem::path truth_masks;   ///< Folder of mask images; empty: the truth's own.
  std::filesystem::path body_camera;   ///< EuRoC's sensor.yaml; empty: found beside the truth.
  std::string association;             ///< "masks", "boxes", "centres", or empty for the best there is.
  std::vector<std::string> fail_if;
  bool json = false;
  bool quiet = false;
};

/// `study object-size`.
struct StudyOptions {
  std::vector<std::filesystem::path> recordings;  ///< Folders made by kinetrace-simulate.
  std::vector<int> windows{1, 5, 10, 20};         ///< Frames of an object's window.
  std::string masks = "detections";               ///< Or "instances": the exact ones.
  ConfigSource config;
  std::filesystem::path out;
  bool quiet = false;
};

struct FigureOptions {
  std::filesystem::path run;
  std::optional<std::int64_t> frame;    ///< None: the frame that shows most.
  std::optional<std::uint32_t> object;  ///< None: the one that shows best in that frame.
  std::filesystem::path out;            ///< PNG file; empty: figure.png in the run folder.
  std::filesystem::path overlay;        ///< Folder for a picture of each frame; empty: none.
  std::string dataset;                  ///< "LAYOUT:PATH" where the recording lies now; empty: where it was.
  bool quiet = false;
};

/// Asked for help or the version, which has been printed.
struct NothingToDo {};

using Command =
    std::variant<RunOptions, PlanOptions, ConfigOptions, EvaluateOptions, StudyOptions, FigureOptions, NothingToDo>;

/// Reads the command line. Failures: kUsage.
[[nodiscard]] Outcome<Command> parse_command_line(int argc, const char* const* argv);

}  // namespace kinetrace::app

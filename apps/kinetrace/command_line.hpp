// What the user asked for.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "failure.hpp"
#include "network_options.hpp"

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

struct RunOptions {
  SourceOptions source;
  UntilOptions until;
  std::string segmentation;  ///< "motion", "none", "onnx[:MODEL]", "dds", "masks:LEFT[,RIGHT]", or empty for the
                             ///< configured one.
  ConfigSource config;
  std::filesystem::path out;
  bool images = false;  ///< Also the rectified left images.
  RawOutputOptions raw;
  std::string publish;  ///< File with keys dds.*; empty: nothing is published.
  bool json = false;
  bool quiet = false;
};

struct RecordOptions {
  SourceOptions source;
  UntilOptions until;
  RawOutputOptions raw;
  bool quiet = false;
};

struct DoctorOptions {
  std::string camera;    ///< Camera file; empty: only list the devices.
  std::string publish;   ///< As for a run.
  double seconds = 2.0;  ///< Watch the images for so long.
  ConfigSource config;
};

struct BenchOptions {
  SourceOptions source;  ///< A recording.
  std::string segmentation;
  ConfigSource config;
  int repeat = 3;
  std::string out;      ///< JSON; empty: none.
  std::string against;  ///< An earlier one; empty: no comparison.
};

struct PlanOptions {
  ConfigSource config;
  std::string publish;  ///< As for a run.
  int width_px = 0;     ///< 0: as the configuration says.
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

struct SummaryOptions {
  std::filesystem::path run;
  bool json = false;
};

struct FigureOptions {
  std::filesystem::path run;
  std::optional<std::int64_t> frame;    ///< None: the frame that shows most.
  std::optional<std::uint32_t> object;  ///< None: the one that shows best in that frame.
  std::filesystem::path out;            ///< PNG file; empty: figure.png in the run folder.
  std::filesystem::path overlay;        ///< Folder for a picture of each frame; empty: none.
  std::filesystem::path film;           ///< The same, with the trajectories so far below; empty: none.
  std::string dataset;                  ///< "LAYOUT:PATH" where the recording lies now; empty: where it was.
  bool quiet = false;
};

/// Names of those who get keys; none at all: one device and one viewer.
struct KeysOptions {
  std::filesystem::path out;  ///< New, or one that holds an authority, which then certifies the new ones.
  std::vector<std::string> devices;
  std::vector<std::string> viewers;
  std::vector<std::string> segmenters;
  int days = 365;                        ///< Valid for so long.
  std::string ros_prefix = "kinetrace";  ///< As dds.ros2.prefix; it is part of the topics' names.
};

struct MonitorOptions {
  NetworkOptions network;
  bool json = false;
  bool quiet = false;
  std::filesystem::path record;  ///< MCAP file; empty: none.
  double seconds = 0.0;          ///< 0: until a signal comes.
  int messages = 0;              ///< Ends after so many of Kinetrace's own topics; 0: never.
};

struct SegmentOptions {
  std::vector<std::filesystem::path> images;  ///< Files, or folders of files.
  std::filesystem::path model;                ///< YAML; empty: the one that comes with Kinetrace.
  std::filesystem::path out;
  int threads = 1;
  bool quiet = false;
};

struct MaskOptions {
  NetworkOptions network;
  std::filesystem::path left_dir;
  std::filesystem::path right_dir;  ///< Empty: none.
  bool by_order = false;            ///< Files are frames in the order of their names, not by number.
  double seconds = 0.0;             ///< 0: until a signal comes.
  bool quiet = false;
};

/// Asked for help or the version, which has been printed.
struct NothingToDo {};

using Command = std::variant<RunOptions, RecordOptions, DoctorOptions, BenchOptions, PlanOptions, ConfigOptions,
                             EvaluateOptions, StudyOptions, FigureOptions, KeysOptions, MonitorOptions, MaskOptions,
                             SegmentOptions, SummaryOptions, NothingToDo>;

/// Reads the command line. Failures: kUsage.
[[nodiscard]] Outcome<Command> parse_command_line(int argc, const char* const* argv);

}  // namespace kinetrace::app

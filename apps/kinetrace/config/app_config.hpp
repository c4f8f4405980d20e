// The whole configuration of the program: all keys of a file and of --set.
#pragma once

#include <array>
#include <functional>
#include <string>

#include "cli/shared_options.hpp"
#include "config/board_config.hpp"
#include "config/config_fields.hpp"
#include "config/input_config.hpp"
#include "config/live_config.hpp"
#include "kinetrace/hal/rectifier.hpp"
#include "kinetrace/pipeline/config.hpp"

namespace kinetrace::app {

/// Contents of the run folder; see RecordingConfig.
struct OutputConfig {
  bool mots = true;
  bool observations = true;
  bool points = true;
  bool colmap = true;
};

/// Processing of a frame.
struct ProcessingConfig {
  int threads = 2;  ///< Threads that share a frame's work, [1, 4]; without those of capture, networks and publishing.

  /// Upper bound: the number of cores.
  [[nodiscard]] int workers() const;
  /// Errors: kInvalidConfig.
  [[nodiscard]] Status validate() const;
};

struct AppConfig {
  BoardConfig board;
  hal::RectifierConfig rectification;
  OutputConfig output;
  InputConfig input;
  LiveConfig live;
  ProcessingConfig processing;
  pipeline::PipelineConfig pipeline;

  [[nodiscard]] Status validate() const;
  /// The values that name a file or a folder.
  [[nodiscard]] std::array<std::string*, 4> paths();
};

template <typename Visitor>
void visit_fields(AppConfig& config, Visitor&& visit) {
  visit_fields(config.board, visit);
  visit("rectification.keep_borders", config.rectification.keep_borders,
        "borders: 0 cuts away pixels without image data, 1 keeps every source pixel; where the calibration leaves the "
        "choice");
  visit("output.mots", config.output.mots, "file mots.txt: the tracked masks");
  visit("output.observations", config.output.observations,
        "file observations.bin, which `kinetrace refine` needs: 24 bytes a point and frame");
  visit("output.points", config.output.points, "folder points/: coloured point clouds");
  visit("output.colmap", config.output.colmap, "folder colmap/: one COLMAP model per body");
  visit_fields(config.input, visit);
  visit_fields(config.live, visit);
  visit("processing.threads", config.processing.threads,
        "threads that share the work of a frame, no more than there are cores; the result does not depend on their "
        "number");
  pipeline::visit_fields(config.pipeline, visit);
}

/// Defaults, then the board, the file, `prepare` and the settings of --set; checked as a whole. Paths in the file are
/// relative to it, those of --set to the working folder.
/// `segmentation`: value of --segmentation; empty: the configured one. Errors: kInvalidConfig, kNotFound, kIo,
/// kInvalidArgument (segmentation).
[[nodiscard]] Result<AppConfig> load_config(const ConfigSource& source, const std::string& segmentation = "",
                                            const std::function<void(AppConfig&)>& prepare = {});

}  // namespace kinetrace::app

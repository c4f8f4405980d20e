#include "config/app_config.hpp"

#include <algorithm>
#include <cmath>
#include <thread>

#include "cli/messages.hpp"
#include "config/board_profiles.hpp"
#include "config/config_file.hpp"
#include "config/size_file.hpp"
#include "kinetrace/core/config_check.hpp"
#include "kinetrace/segmentation/config.hpp"

namespace kinetrace::app {

int ProcessingConfig::workers() const {
  return std::min(threads, std::max(1, static_cast<int>(std::thread::hardware_concurrency())));
}

Status ProcessingConfig::validate() const {
  return check_range("processing.threads", threads, 1, 4);
}

Status AppConfig::validate() const {
  const double budget_mib = pipeline.memory.budget_mib;
  if (board.memory_mib > 0 && budget_mib > board.memory_mib) {
    return fail(ErrorCode::kInvalidConfig,
                "memory.budget_mib = " + std::to_string(std::lround(budget_mib)) +
                    " is more than the board has: board.memory_mib = " + std::to_string(board.memory_mib));
  }
  for (const Status& status :
       {board.validate(), rectification.validate(), live.validate(), processing.validate(), pipeline.validate()}) {
    if (!status) {
      return status;
    }
  }
  return {};
}

std::array<std::string*, 4> AppConfig::paths() {
  segmentation::SegmentationConfig& segmentation = pipeline.segmentation;
  return {&segmentation.left_dir, &segmentation.right_dir, &segmentation.onnx.model, &pipeline.trajectory.sizes};
}

Result<AppConfig> load_config(const ConfigSource& source, const std::string& segmentation,
                              const std::function<void(AppConfig&)>& prepare) {
  AppConfig config;
  const ConfigFields fields = fields_of(config);
  ConfigNotes notes;
  if (!source.board.empty()) {
    if (const Status status = apply_board(source.board, fields); !status) {
      return Unexpected(status.error());
    }
  }
  if (!source.file.empty()) {
    if (const Status status = read_config_file(source.file, fields, {}, &notes); !status) {
      return Unexpected(status.error());
    }
    resolve_paths(source.file, config.paths());
  }
  if (prepare) {
    prepare(config);
  }
  for (const std::string& setting : source.settings) {
    if (const Status status = apply_setting(setting, fields, &notes); !status) {
      return Unexpected(status.error());
    }
  }
  for (const std::string& note : notes) {
    print_warning(note);
  }
  if (!segmentation.empty()) {
    const auto choice = segmentation::parse_segmentation(segmentation);
    if (!choice) {
      return fail(choice.error().code, "--segmentation " + segmentation + ": " + choice.error().message);
    }
    config.pipeline.segmentation.mode = choice->mode;
    config.pipeline.segmentation.left_dir = choice->left_dir;
    config.pipeline.segmentation.right_dir = choice->right_dir;
    if (!choice->onnx.model.empty()) {
      config.pipeline.segmentation.onnx.model = choice->onnx.model;
    }
  }
  if (const std::string& sizes = config.pipeline.trajectory.sizes; !sizes.empty()) {
    const Result<trajectory::SizeTable> table = read_size_file(sizes);
    if (!table) {
      return fail(table.error().code, "trajectory.sizes: " + table.error().message);
    }
    config.pipeline.trajectory.size_table = *table;
  }
  if (const Status status = config.validate(); !status) {
    return Unexpected(status.error());
  }
  return config;
}

}  // namespace kinetrace::app

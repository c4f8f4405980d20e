#include "app_config.hpp"

#include "config_file.hpp"
#include "kinetrace/segmentation/config.hpp"

namespace kinetrace::app {

Status AppConfig::validate() const {
  for (const Status& status : {rectification.validate(), live.validate(), pipeline.validate()}) {
    if (!status) {
      return status;
    }
  }
  return {};
}

Result<AppConfig> load_config(const ConfigSource& source, const std::string& segmentation) {
  AppConfig config;
  const ConfigFields fields = fields_of(config);
  if (!source.file.empty()) {
    if (const Status status = read_config_file(source.file, fields); !status) {
      return tl::unexpected(status.error());
    }
  }
  for (const std::string& setting : source.settings) {
    if (const Status status = apply_setting(setting, fields); !status) {
      return tl::unexpected(status.error());
    }
  }
  if (!segmentation.empty()) {
    const auto choice = segmentation::parse_segmentation(segmentation);
    if (!choice) {
      return fail(choice.error().code, "--segmentation " + segmentation + ": " + choice.error().message);
    }
    config.pipeline.segmentation.mode = choice->mode;
    config.pipeline.segmentation.left_dir = choice->left_dir;
    config.pipeline.segmentation.right_dir = choice->right_dir;
  }
  if (const Status status = config.validate(); !status) {
    return tl::unexpected(status.error());
  }
  return config;
}

}  // namespace kinetrace::app

// Options of a run.
#pragma once

#include <filesystem>
#include <string>

#include "cli/shared_options.hpp"

namespace kinetrace::app {

struct RunOptions {
  SourceOptions source;
  UntilOptions until;
  std::string segmentation;  ///< "auto[:MODEL]", "motion", "none", "onnx[:MODEL]", "dds", "masks:LEFT[,RIGHT]", or
                             ///< empty for the configured one.
  ConfigSource config;
  std::filesystem::path out;
  std::string refine;   ///< "batch": refine the whole recording afterwards; empty: do not.
  bool images = false;  ///< Also the rectified left images.
  RawOutputOptions raw;
  std::filesystem::path save_calibration;  ///< Path for the corrected calibration; empty: not saved.
  std::string publish;                     ///< File with keys dds.*; empty: nothing is published.
  bool json = false;
  bool quiet = false;
};

}  // namespace kinetrace::app

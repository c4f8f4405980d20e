// What a run is asked to do.
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
  std::string refine;   ///< "batch": the whole recording is refined afterwards; empty: it is not.
  bool images = false;  ///< Also the rectified left images.
  RawOutputOptions raw;
  std::filesystem::path save_calibration;  ///< The corrected calibration goes here; empty: nowhere.
  std::string publish;                     ///< File with keys dds.*; empty: nothing is published.
  bool json = false;
  bool quiet = false;
};

}  // namespace kinetrace::app

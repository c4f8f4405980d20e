// Network options of commands.
#pragma once

#include <optional>
#include <string>

namespace kinetrace::app {

/// The file of a run's --publish and the options that override it.
struct NetworkOptions {
  std::string file;  ///< With keys dds.*; empty: their defaults.
  std::optional<int> domain;
  std::string interface;  ///< Empty: as in the file.
  std::string device;     ///< Empty: all devices, or that of the file if one is needed.
};

}  // namespace kinetrace::app

// Where on the network a command reads or writes.
#pragma once

#include <optional>
#include <string>

namespace kinetrace::app {

/// The file of a run's --publish, and what stands above it.
struct NetworkOptions {
  std::string file;  ///< With keys dds.*; empty: their defaults.
  std::optional<int> domain;
  std::string interface;  ///< Empty: as in the file.
  std::string device;     ///< Empty: all, or as in the file where one is needed.
};

}  // namespace kinetrace::app

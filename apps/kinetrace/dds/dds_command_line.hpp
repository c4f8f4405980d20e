// The commands that speak DDS: their options, and what they do in a program that has been built with DDS. Without, they
// fail with kUsage.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "dds/dds_options.hpp"

namespace kinetrace::app {

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

struct MaskOptions {
  NetworkOptions network;
  std::string folders;    ///< "LEFT_DIR[,RIGHT_DIR]"
  bool by_order = false;  ///< Files are frames in the order of their names, not by number.
  double seconds = 0.0;   ///< 0: until a signal comes.
  bool quiet = false;
};

[[nodiscard]] int keys_command(const KeysOptions& options);
[[nodiscard]] int monitor_command(const MonitorOptions& options);
[[nodiscard]] int mask_command(const MaskOptions& options);

}  // namespace kinetrace::app

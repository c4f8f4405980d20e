// Options and entry points of the DDS commands. In a program built without DDS they fail with kUsage.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "dds/dds_options.hpp"

namespace kinetrace::app {

/// Names of participants that get keys; without any name: one device and one viewer.
struct KeysOptions {
  std::filesystem::path out;  ///< A new folder, or one with an authority, which then certifies the new participants.
  std::vector<std::string> devices;
  std::vector<std::string> viewers;
  std::vector<std::string> segmenters;
  int days = 365;                        ///< Validity.
  std::string ros_prefix = "kinetrace";  ///< Value of dds.ros2.prefix, part of the topic names.
};

struct MonitorOptions {
  NetworkOptions network;
  bool json = false;
  bool quiet = false;
  std::filesystem::path record;  ///< MCAP file; empty: none.
  double seconds = 0.0;          ///< 0: until a signal comes.
  int messages = 0;              ///< Ends after this number of messages of native topics; 0: never.
};

struct MaskOptions {
  NetworkOptions network;
  std::string folders;    ///< "LEFT_DIR[,RIGHT_DIR]"
  bool by_order = false;  ///< Files are assigned to frames by the order of their names, not by number.
  double seconds = 0.0;   ///< 0: until a signal comes.
  bool quiet = false;
};

[[nodiscard]] int keys_command(const KeysOptions& options);
[[nodiscard]] int monitor_command(const MonitorOptions& options);
[[nodiscard]] int mask_command(const MaskOptions& options);

}  // namespace kinetrace::app

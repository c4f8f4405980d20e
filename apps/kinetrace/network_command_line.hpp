// The commands that speak DDS, and their options.
#pragma once

#include <string>

#include "command_line.hpp"

// NOLINTNEXTLINE(readability-identifier-naming): theirs.
namespace CLI {
class App;
}

namespace kinetrace::app {

void add_keys(CLI::App& app, KeysOptions& options);
void add_monitor(CLI::App& app, MonitorOptions& options, std::string& record);
void add_masks(CLI::App& app, MaskOptions& options, std::string& folders);

/// With what add_masks has read as "LEFT_DIR[,RIGHT_DIR]".
[[nodiscard]] MaskOptions with_folders(MaskOptions options, const std::string& folders);

}  // namespace kinetrace::app

// The configurations of config/boards, in the program.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "config/config_fields.hpp"

namespace kinetrace::app {

struct BoardProfile {
  std::string_view name;  ///< "raspberry-pi-5": of the file.
  std::string_view yaml;
};

/// By name.
[[nodiscard]] std::span<const BoardProfile> board_profiles() noexcept;

/// As a configuration file would. Errors: kInvalidConfig for a name that is not known, with those that are.
[[nodiscard]] Status apply_board(std::string_view name, const ConfigFields& fields);

}  // namespace kinetrace::app

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

/// Sets the fields of a profile like a configuration file. Errors: kInvalidConfig (unknown name; lists the known ones).
[[nodiscard]] Status apply_board(std::string_view name, const ConfigFields& fields);

}  // namespace kinetrace::app

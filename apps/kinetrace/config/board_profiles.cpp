#include "config/board_profiles.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "config/config_file.hpp"
#include "kinetrace/core/nearest_name.hpp"

namespace kinetrace::app {

Status apply_board(std::string_view name, const ConfigFields& fields) {
  const auto profiles = board_profiles();
  const auto found =
      std::find_if(profiles.begin(), profiles.end(), [&](const BoardProfile& profile) { return profile.name == name; });
  if (found != profiles.end()) {
    return read_config_text("board " + std::string(name), found->yaml, fields);
  }
  std::string known;
  std::vector<std::string_view> names;
  for (const BoardProfile& profile : profiles) {
    known += (known.empty() ? "" : ", ") + std::string(profile.name);
    names.push_back(profile.name);
  }
  return fail(ErrorCode::kInvalidConfig, "--board " + std::string(name) + ": not known; known are " + known +
                                             ", and a board of your own is a file for --config" +
                                             did_you_mean(name, names));
}

}  // namespace kinetrace::app

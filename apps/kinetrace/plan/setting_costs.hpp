// Memory cost of each setting.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "config/config_fields.hpp"
#include "kinetrace/core/result.hpp"

namespace kinetrace::app {

struct SettingCost {
  std::string key;
  std::string value;         ///< Current value.
  double bytes = 0.0;        ///< Cost of an increment by one; for a switch: of turning it on.
  double share_bytes = 0.0;  ///< Cost of the current value, assuming equal increments.
};

/// Costs from plans that differ in one setting each. `total_bytes` plans with the current fields and fails if they are
/// invalid; the fields are restored. Sorted by share, largest first; settings without cost are left out.
[[nodiscard]] std::vector<SettingCost> setting_costs(const ConfigFields& fields,
                                                     const std::function<Result<double>()>& total_bytes);

}  // namespace kinetrace::app

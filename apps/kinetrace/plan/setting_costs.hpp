// Which setting takes how much memory.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "config/config_fields.hpp"
#include "kinetrace/core/result.hpp"

namespace kinetrace::app {

struct SettingCost {
  std::string key;
  std::string value;         ///< As it is set.
  double bytes = 0.0;        ///< What one more takes; of a switch: what it takes when on.
  double share_bytes = 0.0;  ///< Of the value as it is set, were each one alike.
};

/// What the plan says of configurations that differ in one setting each. `total_bytes` plans with the fields as they
/// are, and fails where they are not valid; fields are as before afterwards. The largest share comes first; settings
/// that take nothing are left out.
[[nodiscard]] std::vector<SettingCost> setting_costs(const ConfigFields& fields,
                                                     const std::function<Result<double>()>& total_bytes);

}  // namespace kinetrace::app

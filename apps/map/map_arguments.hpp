// Options of `kinetrace map` as what they mean.
#pragma once

#include <optional>
#include <string>

#include "cli/failure.hpp"
#include "kinetrace/geo/alignment.hpp"
#include "kinetrace/geo/geodesy.hpp"
#include "map/map_options.hpp"

namespace kinetrace::map {

/// The reference is a topic, so the run goes on.
[[nodiscard]] bool is_live(const app::MapOptions& options);
/// Its name as ROS says it; empty where it has none.
[[nodiscard]] std::string live_topic(const app::MapOptions& options);

// Errors: kUsage.

[[nodiscard]] app::Outcome<std::optional<geo::Geodetic>> parse_origin(const app::MapOptions& options);
[[nodiscard]] app::Outcome<geo::AlignmentConfig> parse_config(const app::MapOptions& options);

}  // namespace kinetrace::map

// Options that say where the camera was, as what they mean.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "cli/failure.hpp"
#include "kinetrace/geo/alignment.hpp"
#include "kinetrace/geo/geodesy.hpp"
#include "kinetrace/geo/reference.hpp"
#include "map/reference_options.hpp"

namespace kinetrace::map {

/// The reference is a topic, so the run goes on.
[[nodiscard]] bool is_live(const app::ReferenceOptions& options);
/// Its name as ROS says it; empty where it has none.
[[nodiscard]] std::string live_topic(const app::ReferenceOptions& options);

// Errors: kUsage.

[[nodiscard]] app::Outcome<std::optional<geo::Geodetic>> parse_origin(const app::ReferenceOptions& options);
/// `recorded_ns`: when the recording was made.
[[nodiscard]] app::Outcome<geo::ReferenceSource> parse_source(const app::ReferenceOptions& options,
                                                              std::int64_t recorded_ns);
[[nodiscard]] app::Outcome<geo::AlignmentConfig> parse_config(const app::ReferenceOptions& options);

}  // namespace kinetrace::map

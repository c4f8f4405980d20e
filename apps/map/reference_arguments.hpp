// Options for a position reference, parsed.
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

/// Whether the reference is a topic, so that the run is live.
[[nodiscard]] bool is_live(const app::ReferenceOptions& options);
/// Its name in ROS; empty without a topic.
[[nodiscard]] std::string live_topic(const app::ReferenceOptions& options);

// Errors: kUsage.

[[nodiscard]] app::Outcome<std::optional<geo::Geodetic>> parse_origin(const app::ReferenceOptions& options);
/// `recorded_ns`: when the recording was made.
[[nodiscard]] app::Outcome<geo::ReferenceSource> parse_source(const app::ReferenceOptions& options,
                                                              std::int64_t recorded_ns);
[[nodiscard]] app::Outcome<geo::AlignmentConfig> parse_config(const app::ReferenceOptions& options);

}  // namespace kinetrace::map

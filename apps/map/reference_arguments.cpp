#include "reference_arguments.hpp"

#include <algorithm>

#include "kinetrace/core/text_rows.hpp"

namespace kinetrace::map {

using app::Failure;
using app::Outcome;
using app::ReferenceOptions;

namespace {

/// Three numbers between commas.
Outcome<Eigen::Vector3d> parse_triple(const std::string& text, const char* option) {
  Eigen::Vector3d values;
  std::string_view rest = text;
  for (Eigen::Index i = 0; i < 3; ++i) {
    const std::size_t length = i < 2 ? rest.find(',') : rest.size();
    const auto number = length == std::string_view::npos ? std::nullopt : parse_number(rest.substr(0, length));
    if (!number) {
      return Unexpected(Failure{app::ExitCode::kUsage, std::string(option) +
                                                           ": expected three numbers with commas "
                                                           "between them, got " +
                                                           text});
    }
    values[i] = *number;
    rest.remove_prefix(std::min(length + 1, rest.size()));
  }
  return values;
}

}  // namespace

std::string live_topic(const ReferenceOptions& options) {
  constexpr std::string_view kFormat = "navsatfix:";
  return options.source.starts_with(kFormat) ? options.source.substr(kFormat.size()) : "";
}

bool is_live(const ReferenceOptions& options) {
  return options.source.starts_with("navsatfix:");
}

Outcome<std::optional<geo::Geodetic>> parse_origin(const ReferenceOptions& options) {
  if (options.origin.empty()) {
    return std::nullopt;
  }
  const Outcome<Eigen::Vector3d> origin = parse_triple(options.origin, "--origin");
  if (!origin) {
    return Unexpected(origin.error());
  }
  return geo::Geodetic{origin->x(), origin->y(), origin->z()};
}

Outcome<geo::ReferenceSource> parse_source(const ReferenceOptions& options, std::int64_t recorded_ns) {
  const std::size_t colon = options.source.find(':');
  geo::ReferenceSource source;
  bool known = false;
  for (const auto& [name, format] : geo::kReferenceFormats) {
    if (name == options.source.substr(0, colon)) {
      source.format = format;
      known = true;
    }
  }
  if (!known || colon == std::string::npos || colon + 1 == options.source.size()) {
    return Unexpected(
        Failure{app::ExitCode::kUsage,
                "--reference: expected FORMAT:PATH with oxts, nmea, gpx, euroc or csv (or, of kinetrace map, "
                "navsatfix:TOPIC), got " +
                    options.source});
  }
  source.path = options.source.substr(colon + 1);
  source.near_time_ns = recorded_ns;
  const Outcome<std::optional<geo::Geodetic>> origin = parse_origin(options);
  if (!origin) {
    return Unexpected(origin.error());
  }
  source.origin = *origin;
  return source;
}

Outcome<geo::AlignmentConfig> parse_config(const ReferenceOptions& options) {
  const Outcome<Eigen::Vector3d> lever_arm = parse_triple(options.lever_arm_m, "--lever-arm");
  if (!lever_arm) {
    return Unexpected(lever_arm.error());
  }
  geo::AlignmentConfig config;
  config.freedom = options.dof == 4 ? geo::Freedom::kYaw : geo::Freedom::kRotation;
  config.lever_arm_m = *lever_arm;
  config.time_offset_s = options.time_offset_s.value_or(config.time_offset_s);
  // On one machine, clocks differ at most by the latency of the results.
  constexpr double kLiveSearch_s = 1.0;
  config.max_time_offset_s =
      options.max_time_offset_s.value_or(is_live(options) ? kLiveSearch_s : config.max_time_offset_s);
  config.path_drift = options.drift_percent / 100.0;
  return config;
}

}  // namespace kinetrace::map

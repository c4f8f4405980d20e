// Calendar dates as nanoseconds since 1970.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace kinetrace::geo {

inline constexpr std::int64_t kSecond_ns = 1'000'000'000;
inline constexpr std::int64_t kDay_ns = 86'400 * kSecond_ns;

/// Midnight of a day, UTC; none if not a day from 1970 to 2199.
[[nodiscard]] std::optional<std::int64_t> day_start_ns(int year, int month, int day);

/// `hhmmss` or `hhmmss.fff...` since midnight, as in NMEA; none if invalid. A leap second counts as the next second.
[[nodiscard]] std::optional<std::int64_t> time_of_day_ns(std::string_view text);

/// ISO 8601: `2011-09-26T13:02:25.594Z`, with 'T' or a blank between date and time, with `Z`, `+hh:mm`, `-hh:mm`, or
/// nothing for UTC.
[[nodiscard]] std::optional<std::int64_t> parse_date_time_ns(std::string_view text);

/// The inverse, with milliseconds: `2011-09-26T13:02:25.594Z`.
[[nodiscard]] std::string date_time_text(std::int64_t time_ns);

}  // namespace kinetrace::geo

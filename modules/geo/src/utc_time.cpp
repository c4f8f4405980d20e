#include "utc_time.hpp"

#include <chrono>
#include <cstdio>

namespace kinetrace::geo {
namespace {

std::optional<int> digits(std::string_view text, std::size_t at, std::size_t count) {
  if (text.size() < at + count) {
    return std::nullopt;
  }
  int value = 0;
  for (const char c : text.substr(at, count)) {
    if (c < '0' || c > '9') {
      return std::nullopt;
    }
    value = 10 * value + (c - '0');
  }
  return value;
}

/// `.fff...` as nanoseconds, 0 without digits; further digits are truncated.
std::optional<std::int64_t> fraction_ns(std::string_view text) {
  if (text.empty()) {
    return 0;
  }
  if (text.front() != '.' || text.size() == 1) {
    return std::nullopt;
  }
  std::int64_t value = 0;
  std::int64_t unit = kSecond_ns;
  for (const char c : text.substr(1)) {
    if (c < '0' || c > '9') {
      return std::nullopt;
    }
    unit /= 10;
    value += unit * (c - '0');
  }
  return value;
}

/// Suffix of the time: `Z`, `+hh:mm`, `-hhmm`, nothing.
std::optional<std::int64_t> zone_ns(std::string_view text) {
  if (text.empty() || text == "Z") {
    return 0;
  }
  const std::size_t minutes_at = text.size() == 6 && text[3] == ':' ? 4 : 3;
  const auto hours = digits(text, 1, 2);
  const auto minutes = digits(text, minutes_at, 2);
  if ((text.front() != '+' && text.front() != '-') || text.size() != minutes_at + 2 || !hours || !minutes ||
      *hours > 14 || *minutes > 59) {
    return std::nullopt;
  }
  const std::int64_t ahead_ns = std::int64_t{60} * (*hours * 60 + *minutes) * kSecond_ns;
  return text.front() == '+' ? ahead_ns : -ahead_ns;
}

std::optional<std::int64_t> time_ns(std::optional<int> hour, std::optional<int> minute, std::optional<int> second,
                                    std::string_view fraction) {
  const auto below_second_ns = fraction_ns(fraction);
  if (!hour || !minute || !second || !below_second_ns || *hour > 23 || *minute > 59 || *second > 60) {
    return std::nullopt;
  }
  return ((*hour * 60 + *minute) * 60 + *second) * kSecond_ns + *below_second_ns;
}

}  // namespace

std::optional<std::int64_t> day_start_ns(int year, int month, int day) {
  const std::chrono::year_month_day date{std::chrono::year(year), std::chrono::month(static_cast<unsigned>(month)),
                                         std::chrono::day(static_cast<unsigned>(day))};
  if (!date.ok() || year < 1970 || year > 2199) {
    return std::nullopt;
  }
  return std::chrono::sys_days(date).time_since_epoch().count() * kDay_ns;
}

std::optional<std::int64_t> time_of_day_ns(std::string_view text) {
  const std::string_view fraction = text.size() > 6 ? text.substr(6) : std::string_view{};
  return time_ns(digits(text, 0, 2), digits(text, 2, 2), digits(text, 4, 2), fraction);
}

std::optional<std::int64_t> parse_date_time_ns(std::string_view text) {
  const auto year = digits(text, 0, 4);
  const auto month = digits(text, 5, 2);
  const auto day = digits(text, 8, 2);
  if (!year || !month || !day || text.size() < 19 || text[4] != '-' || text[7] != '-' || text[13] != ':' ||
      text[16] != ':' || (text[10] != 'T' && text[10] != ' ')) {
    return std::nullopt;
  }
  const std::string_view after = text.substr(19);
  const std::size_t zone_at = std::min(after.find_first_of("Z+-"), after.size());
  const auto start_ns = day_start_ns(*year, *month, *day);
  const auto clock_ns =
      time_ns(digits(text, 11, 2), digits(text, 14, 2), digits(text, 17, 2), after.substr(0, zone_at));
  const auto ahead_ns = zone_ns(after.substr(zone_at));
  return start_ns && clock_ns && ahead_ns ? std::optional(*start_ns + *clock_ns - *ahead_ns) : std::nullopt;
}

std::string date_time_text(std::int64_t time_ns) {
  const std::chrono::sys_time<std::chrono::nanoseconds> time{std::chrono::nanoseconds(time_ns)};
  const auto rounded = std::chrono::round<std::chrono::milliseconds>(time);
  const auto day = std::chrono::floor<std::chrono::days>(rounded);
  const std::chrono::year_month_day date(day);
  const std::chrono::hh_mm_ss clock(rounded - day);
  char text[64];
  std::snprintf(text, sizeof text, "%04d-%02u-%02uT%02d:%02d:%02d.%03dZ", static_cast<int>(date.year()),
                static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()),
                static_cast<int>(clock.hours().count()), static_cast<int>(clock.minutes().count()),
                static_cast<int>(clock.seconds().count()), static_cast<int>(clock.subseconds().count()));
  return text;
}

}  // namespace kinetrace::geo

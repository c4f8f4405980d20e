#include "text_file.hpp"

#include <charconv>
#include <chrono>
#include <fstream>
#include <limits>

#include "kinetrace/core/text_rows.hpp"
#include "messages.hpp"

namespace kinetrace::hal {
namespace {

constexpr std::uintmax_t kMaxTextBytes = std::uintmax_t{256} << 20;
constexpr std::string_view kBlanks = " \t\r\f\v";

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) {
    return {};
  }
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

template <typename T>
std::optional<T> parse_whole(std::string_view text) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) {
    return std::nullopt;
  }
  return value;
}

std::optional<std::int64_t> parse_date_ns(std::string_view text) {
  if (text.size() < 19 || (text[10] != ' ' && text[10] != 'T')) {
    return std::nullopt;
  }
  const auto field = [text](std::size_t at, std::size_t length) { return parse_whole<int>(text.substr(at, length)); };
  const auto year = field(0, 4);
  const auto month = field(5, 2);
  const auto day = field(8, 2);
  const auto hour = field(11, 2);
  const auto minute = field(14, 2);
  const auto seconds = parse_whole<int>(text.substr(17, 2));
  if (!year || !month || !day || !hour || !minute || !seconds) {
    return std::nullopt;
  }
  const std::chrono::year_month_day date{std::chrono::year(*year), std::chrono::month(static_cast<unsigned>(*month)),
                                         std::chrono::day(static_cast<unsigned>(*day))};
  if (!date.ok()) {
    return std::nullopt;
  }
  std::int64_t fraction_ns = 0;
  if (text.size() > 19) {
    const std::string digits = std::string(text.substr(20)) + "000000000";
    const auto parsed = parse_whole<std::int64_t>(std::string_view(digits).substr(0, 9));
    if (text[19] != '.' || !parsed) {
      return std::nullopt;
    }
    fraction_ns = *parsed;
  }
  const std::int64_t days = std::chrono::sys_days(date).time_since_epoch().count();
  return (((days * 24 + *hour) * 60 + *minute) * 60 + *seconds) * 1'000'000'000 + fraction_ns;
}

}  // namespace

Result<std::string> read_text(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) {
    return fail(ErrorCode::kNotFound, path.string() + ": no such file; check the path");
  }
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error || size == 0 || size > kMaxTextBytes) {
    return fail(ErrorCode::kBadFormat, concat(path.string(), ": is ", size == 0 ? "empty" : "too large",
                                              " for a text file of a data set; copy it again"));
  }
  std::ifstream file(path, std::ios::binary);
  std::string text(static_cast<std::size_t>(size), '\0');
  if (!file.read(text.data(), static_cast<std::streamsize>(size))) {
    return fail(ErrorCode::kIo, path.string() + ": cannot be read; check its permissions");
  }
  return text;
}

std::vector<std::string_view> content_lines(std::string_view text) {
  std::vector<std::string_view> lines;
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    const std::string_view line = trimmed(text.substr(0, end));
    if (!line.empty() && line.front() != '#') {
      lines.push_back(line);
    }
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  }
  return lines;
}

std::optional<double> parse_double(std::string_view text) {
  return parse_whole<double>(trimmed(text));
}
std::optional<std::int64_t> parse_integer(std::string_view text) {
  return parse_whole<std::int64_t>(trimmed(text));
}

std::optional<std::vector<double>> parse_numbers(std::string_view text) {
  constexpr std::string_view kSeparators = ", \t\r";
  std::vector<double> numbers;
  while (true) {
    const std::size_t first = text.find_first_not_of(kSeparators);
    if (first == std::string_view::npos) {
      return numbers;
    }
    text.remove_prefix(first);
    const std::size_t length = std::min(text.find_first_of(kSeparators), text.size());
    const auto value = parse_whole<double>(text.substr(0, length));
    if (!value) {
      return std::nullopt;
    }
    numbers.push_back(*value);
    text.remove_prefix(length);
  }
}

std::optional<std::int64_t> parse_time_ns(std::string_view text) {
  const std::string_view time = trimmed(text);
  if (time.size() > 10 && time[4] == '-') {
    return parse_date_ns(time);
  }
  return kinetrace::parse_time_ns(time);
}

Result<std::vector<std::int64_t>> read_times_ns(const std::filesystem::path& path) {
  const Result<std::string> text = read_text(path);
  if (!text) {
    return Unexpected(text.error());
  }
  std::vector<std::int64_t> times;
  for (const std::string_view line : content_lines(*text)) {
    const auto time = parse_time_ns(line);
    if (!time) {
      return fail(ErrorCode::kBadFormat,
                  concat(path.string(), ": entry ", std::to_string(times.size() + 1), " '", line.substr(0, 40),
                         "' is no time; expected seconds, nanoseconds or a date"));
    }
    times.push_back(*time);
  }
  return times;
}

Result<std::map<std::int64_t, std::int64_t>> read_frame_times_ns(const std::filesystem::path& path) {
  const Result<std::string> text = read_text(path);
  if (!text) {
    return Unexpected(text.error());
  }
  const std::string_view whole_lines = std::string_view(*text).substr(0, text->rfind('\n') + 1);
  std::map<std::int64_t, std::int64_t> times;
  for (const std::string_view line : content_lines(whole_lines)) {
    const std::size_t blank = line.find(' ');
    const auto number = parse_integer(line.substr(0, blank));
    const auto time_ns = blank == std::string_view::npos ? std::nullopt : parse_integer(line.substr(blank));
    if (number && time_ns) {
      times.emplace(*number, *time_ns);
    }
  }
  return times;
}

}  // namespace kinetrace::hal

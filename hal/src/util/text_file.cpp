#include "util/text_file.hpp"

#include <charconv>
#include <chrono>
#include <utility>

#include "kinetrace/core/input_file.hpp"
#include "kinetrace/core/text_rows.hpp"
#include "kinetrace/hal/frame_list.hpp"
#include "util/messages.hpp"

namespace kinetrace::hal {
namespace {

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

// Parses "2011-09-26 14:06:03.368359168" by the positions of its digits.
std::optional<std::int64_t> parse_date_ns(std::string_view text) {
  constexpr std::string_view kForm = "0000-00-00 00:00:00.";
  constexpr std::size_t kSeparator = 10;  // A blank or a T.
  std::string digits;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool is_digit = text[i] >= '0' && text[i] <= '9';
    const bool wants_digit = i >= kForm.size() || kForm[i] == '0';
    if (is_digit != wants_digit || (!is_digit && text[i] != kForm[i] && !(i == kSeparator && text[i] == 'T'))) {
      return std::nullopt;
    }
    digits.append(is_digit ? 1 : 0, text[i]);
  }
  constexpr std::size_t kNanosecondDigits = 14 + 9;
  return text.size() == kForm.size() ? std::nullopt
                                     : parse_calendar_ns(std::string_view(digits).substr(0, kNanosecondDigits));
}

}  // namespace

Result<std::string> read_text(const std::filesystem::path& path, std::size_t max_bytes) {
  Result<std::string> text = InputFile::read_whole(path, max_bytes);
  if (text && text->empty()) {
    return fail(ErrorCode::kBadFormat, path.string() + ": is empty (0 bytes); copy it again");
  }
  // Editors of Windows begin a text with it.
  if (constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF"; text && text->starts_with(kByteOrderMark)) {
    text->erase(0, kByteOrderMark.size());
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

std::optional<std::int64_t> parse_calendar_ns(std::string_view digits) {
  constexpr std::size_t kDateDigits = 14;
  constexpr std::size_t kFractionDigits = 9;
  constexpr int kEpochYear = 1970;
  if (digits.size() < kDateDigits || digits.size() > kDateDigits + kFractionDigits ||
      digits.find_first_not_of("0123456789") != std::string_view::npos) {
    return std::nullopt;
  }
  const auto field = [digits](std::size_t at, std::size_t length) {
    return parse_whole<unsigned>(digits.substr(at, length)).value_or(0);
  };
  const std::chrono::year_month_day date{std::chrono::year(static_cast<int>(field(0, 4))),
                                         std::chrono::month(field(4, 2)), std::chrono::day(field(6, 2))};
  const unsigned hour = field(8, 2);
  const unsigned minute = field(10, 2);
  const unsigned second = field(12, 2);
  if (!date.ok() || static_cast<int>(date.year()) < kEpochYear || hour > 23 || minute > 59 || second > 59) {
    return std::nullopt;
  }
  std::string fraction(digits.substr(kDateDigits));
  fraction.resize(kFractionDigits, '0');
  const std::int64_t days = std::chrono::sys_days(date).time_since_epoch().count();
  const std::int64_t seconds = ((days * 24 + hour) * 60 + minute) * 60 + second;
  constexpr std::int64_t kSecond_ns = 1'000'000'000;
  if (seconds >= FrameList::kMaxTime_ns / kSecond_ns) {
    return std::nullopt;
  }
  return seconds * kSecond_ns + parse_whole<std::int64_t>(fraction).value_or(0);
}

std::optional<std::int64_t> parse_time_ns(std::string_view text) {
  const std::string_view time = trimmed(text);
  const bool is_date = time.size() > 10 && time[4] == '-';
  const auto time_ns = is_date ? parse_date_ns(time) : kinetrace::parse_time_ns(time);
  return time_ns && FrameList::holds_time(*time_ns) ? time_ns : std::nullopt;
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
                         "' is no time; expected seconds, nanoseconds or a date, before the year 2116"));
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
    if (number && time_ns && FrameList::holds(*number, *time_ns)) {
      times.emplace(*number, *time_ns);
    }
  }
  return times;
}

}  // namespace kinetrace::hal

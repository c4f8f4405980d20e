// Text files: lines, numbers, times.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "kinetrace/core/result.hpp"

namespace kinetrace::hal {

inline constexpr std::size_t kMaxTextBytes = std::size_t{256} << 20;
/// Calibrations have a few kilobytes, a hundred with the detected corners.
inline constexpr std::size_t kMaxCalibrationBytes = std::size_t{1} << 20;

/// Whole content, without a byte order mark. Errors: kNotFound, kIo, kBadFormat (no regular file, empty, or beyond
/// `max_bytes`).
[[nodiscard]] Result<std::string> read_text(const std::filesystem::path& path, std::size_t max_bytes = kMaxTextBytes);

/// Lines without line ends, carriage returns and surrounding blanks; without blank lines and lines that begin with '#'.
[[nodiscard]] std::vector<std::string_view> content_lines(std::string_view text);

/// The whole of `text` as a number; none if it is not one. "nan" and "inf" are numbers here: callers check.
[[nodiscard]] std::optional<double> parse_double(std::string_view text);
[[nodiscard]] std::optional<std::int64_t> parse_integer(std::string_view text);

/// A list of numbers separated by blanks or commas; none if anything else is in it.
[[nodiscard]] std::optional<std::vector<double>> parse_numbers(std::string_view text);

/// Nanoseconds since 1970 of a date and time, YYYYMMDDhhmmss with up to nine digits for the fraction of the second.
/// None if there is no such moment, or before 1970.
[[nodiscard]] std::optional<std::int64_t> parse_calendar_ns(std::string_view digits);

/// Nanoseconds from "2011-09-26 14:06:03.368359168" (taken as UTC), an integer of 16 digits or more (nanoseconds), or
/// seconds ("1.036e-01"). None outside what a FrameList holds.
[[nodiscard]] std::optional<std::int64_t> parse_time_ns(std::string_view text);

/// One time per line. Errors: as read_text; kBadFormat with the line.
[[nodiscard]] Result<std::vector<std::int64_t>> read_times_ns(const std::filesystem::path& path);

/// Times in nanoseconds by frame number, one of each per line. Incomplete lines, also a last one without its end, are
/// skipped: a loss of power leaves such lines. Errors: as read_text.
[[nodiscard]] Result<std::map<std::int64_t, std::int64_t>> read_frame_times_ns(const std::filesystem::path& path);

}  // namespace kinetrace::hal

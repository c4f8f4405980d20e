// Text files of numbers: rows of fields, and errors that name the file and the line. For host-side tools; allocates.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "kinetrace/core/export.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/core/se3.hpp"

namespace kinetrace {

/// The whole of `text` as a number; none if it is no number or not finite.
[[nodiscard]] KINETRACE_API std::optional<double> parse_number(std::string_view text);
[[nodiscard]] KINETRACE_API std::optional<std::int64_t> parse_integer(std::string_view text);
/// Nanoseconds from an integer of at least 16 digits (nanoseconds), or else from seconds; none beyond 146 years.
[[nodiscard]] KINETRACE_API std::optional<std::int64_t> parse_time_ns(std::string_view text);

/// Iterates over the rows of a text file. Blank lines and lines that begin with '#' are skipped. The first mistake
/// sticks: `next()` is false from then on and `status()` has the error, so a reader checks once, at the end.
///
///     while (rows.next()) { x = rows.number(0); ... }
///     return rows.status();
class KINETRACE_API TextRows {
 public:
  enum class Separator : std::uint8_t { kBlanks, kComma };
  enum class QuaternionOrder : std::uint8_t { kRealLast, kRealFirst };

  TextRows(TextRows&&) noexcept = default;
  TextRows& operator=(TextRows&&) noexcept = default;
  TextRows(const TextRows&) = delete;
  TextRows& operator=(const TextRows&) = delete;
  ~TextRows() = default;

  /// Reads the whole file; a byte order mark is skipped. Errors: those of InputFile::read_whole.
  [[nodiscard]] static Result<TextRows> open(const std::filesystem::path& path, Separator separator);

  /// True if the last row ends with a line break; otherwise it may be truncated.
  [[nodiscard]] bool ends_with_whole_row() const noexcept { return content_.empty() || content_.back() == '\n'; }
  /// Ignores a last row without line break: for files still being written, or whose writer was stopped. Before the
  /// first `next`.
  void leave_out_unfinished_row();

  /// Takes the next row as the names of the columns; every later row must have as many fields. Returns the indices of
  /// `names`, kNoColumn for missing ones. Mistake: one of the first `required` names is missing.
  [[nodiscard]] std::vector<std::size_t> columns(const std::vector<std::string_view>& names,
                                                 std::size_t required = kNoColumn);
  static constexpr std::size_t kNoColumn = std::numeric_limits<std::size_t>::max();

  /// Every row from now on must have so many fields.
  void expect_fields(std::size_t count) noexcept { expected_fields_ = count; }

  /// Advances to the next row; false at the end and after a mistake.
  [[nodiscard]] bool next();
  [[nodiscard]] std::size_t size() const noexcept { return fields_.size(); }
  [[nodiscard]] int line() const noexcept { return line_; }

  /// Fields of the row, from 0. A missing field or one of another type is a mistake and reads as zero.
  [[nodiscard]] std::string_view text(std::size_t field);
  [[nodiscard]] double number(std::size_t field);
  [[nodiscard]] std::int64_t integer(std::size_t field);
  [[nodiscard]] std::int64_t time_ns(std::size_t field);
  /// `tx ty tz qx qy qz qw`, or with qw before qx, from `field` on. A mistake if the quaternion's norm differs from 1
  /// by more than 0.01.
  [[nodiscard]] Se3 pose(std::size_t field, QuaternionOrder order = QuaternionOrder::kRealLast);
  /// The upper 3 x 4 part of a transform, row by row. A mistake if it is no rotation to within 0.01.
  [[nodiscard]] Se3 matrix_pose(std::size_t field);

  /// Reports a mistake in the current row: "FILE, line N: REASON".
  void reject(const std::string& reason);
  [[nodiscard]] const Status& status() const noexcept { return status_; }

 private:
  TextRows() = default;
  void split(std::string_view row);

  std::filesystem::path path_;
  Separator separator_ = Separator::kBlanks;
  std::vector<char> content_;  ///< Not a string: a move must not relocate its characters.
  std::size_t position_ = 0;
  int line_ = 0;
  std::size_t expected_fields_ = 0;  ///< 0: any.
  std::vector<std::string_view> fields_;
  Status status_;
};

}  // namespace kinetrace

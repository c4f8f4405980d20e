#include "kinetrace/core/text_rows.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <utility>

#include "kinetrace/core/input_file.hpp"

namespace kinetrace {
namespace {

constexpr std::string_view kBlanks = " \t\r\f\v";
constexpr std::size_t kMaxRow = std::size_t{1} << 24U;
constexpr double kRotationTolerance = 0.01;  // Rounding of the text.

std::string quoted(std::string_view word) {
  constexpr std::size_t kMaxQuoted = 40;
  std::string text(1, '\'');
  text.append(word.substr(0, kMaxQuoted)).append(1, '\'');
  return text;
}

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kBlanks);
  return first == std::string_view::npos ? std::string_view{}
                                         : text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

template <typename Number>
std::optional<Number> parse_whole(std::string_view text) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size() ? std::optional(value) : std::nullopt;
}

// The exponent of a number from the text behind the e; 0 if empty.
std::optional<int> parse_exponent(std::string_view text) {
  if (text.starts_with('+') && !text.starts_with("+-")) {
    text.remove_prefix(1);
  }
  return parse_whole<int>(text);
}

// Digit by digit: Unix time with nanoseconds has more digits than a double holds, and on some processors a long double
// has no more.
std::optional<std::int64_t> parse_seconds_ns(std::string_view text) {
  constexpr int kNanosecondPlaces = 9;
  constexpr int kMaxPlaces = 40;
  const bool negative = text.starts_with('-');
  text.remove_prefix(negative ? 1 : 0);
  const std::size_t end = std::min(text.find_first_of("eE"), text.size());
  const std::optional<int> exponent = end < text.size() ? parse_exponent(text.substr(end + 1)) : 0;
  const std::size_t point = std::min(text.substr(0, end).find('.'), end);
  std::string digits(text.substr(0, point));
  digits.append(text.substr(std::min(point + 1, end), end - std::min(point + 1, end)));
  if (!exponent || *exponent < -kMaxPlaces || *exponent > kMaxPlaces || digits.empty() ||
      digits.find_first_not_of("0123456789") != std::string::npos) {
    return std::nullopt;
  }
  digits.insert(0, 1, '0');  // So that a digit is left before the rounded ones.
  const int places = 1 + static_cast<int>(point) + *exponent + kNanosecondPlaces;
  const auto kept = static_cast<std::size_t>(std::max(places, 0));
  const int up = kept < digits.size() && digits[kept] >= '5' ? 1 : 0;
  digits.resize(kept, '0');
  const std::optional<std::int64_t> whole = kept > 0 ? parse_whole<std::int64_t>(digits) : 0;
  if (!whole || *whole == std::numeric_limits<std::int64_t>::max()) {
    return std::nullopt;
  }
  return (negative ? -1 : 1) * (*whole + up);
}

}  // namespace

std::optional<double> parse_number(std::string_view text) {
  const std::optional<double> value = parse_whole<double>(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

std::optional<std::int64_t> parse_integer(std::string_view text) {
  return parse_whole<std::int64_t>(text);
}

std::optional<std::int64_t> parse_time_ns(std::string_view text) {
  constexpr std::size_t kMinNanosecondDigits = 16;
  // The difference of any two must fit into 64 bits.
  constexpr std::int64_t kLatest_ns = std::numeric_limits<std::int64_t>::max() / 2;
  const bool is_nanoseconds =
      text.size() >= kMinNanosecondDigits && text.find_first_not_of("0123456789") == std::string_view::npos;
  const std::optional<std::int64_t> time_ns = is_nanoseconds ? parse_integer(text) : parse_seconds_ns(text);
  return time_ns && *time_ns >= -kLatest_ns && *time_ns <= kLatest_ns ? time_ns : std::nullopt;
}

Result<TextRows> TextRows::open(const std::filesystem::path& path, Separator separator) {
  Result<std::string> content = InputFile::read_whole(path);
  if (!content) {
    return Unexpected(content.error());
  }
  TextRows rows;
  rows.path_ = path;
  rows.separator_ = separator;
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  rows.content_.assign(content->begin(), content->end());
  if (content->starts_with(kByteOrderMark)) {
    rows.position_ = kByteOrderMark.size();
  }
  return rows;
}

void TextRows::leave_out_unfinished_row() {
  const auto last = std::find(content_.rbegin(), content_.rend(), '\n');
  content_.erase(last.base(), content_.end());
}

std::vector<std::size_t> TextRows::columns(const std::vector<std::string_view>& names, std::size_t required) {
  std::vector<std::size_t> places(names.size(), kNoColumn);
  if (!next()) {
    reject("expected the names of the columns, found the end of the file");
    return places;
  }
  expected_fields_ = fields_.size();
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto found = std::find(fields_.begin(), fields_.end(), names[i]);
    if (found != fields_.end()) {
      places[i] = static_cast<std::size_t>(found - fields_.begin());
    } else if (i < required) {
      const bool has_semicolons = fields_.size() == 1 && fields_[0].find(';') != std::string_view::npos;
      reject("column " + quoted(names[i]) + " is missing" +
             (has_semicolons ? "; expected commas between the fields, found semicolons" : ""));
      break;
    }
  }
  return places;
}

bool TextRows::next() {
  fields_.clear();
  while (status_ && position_ < content_.size()) {
    const std::string_view rest = std::string_view(content_.data(), content_.size()).substr(position_);
    const std::size_t length = std::min(rest.find('\n'), rest.size());
    const std::string_view row = trimmed(rest.substr(0, length));
    position_ += length + 1;
    ++line_;
    if (length > kMaxRow) {
      reject("the row has " + std::to_string(length) + " characters");
      return false;
    }
    if (row.empty() || row.front() == '#') {
      continue;
    }
    split(row);
    if (expected_fields_ != 0 && fields_.size() != expected_fields_) {
      reject("expected " + std::to_string(expected_fields_) + " fields, found " + std::to_string(fields_.size()));
      return false;
    }
    return true;
  }
  return false;
}

void TextRows::split(std::string_view row) {
  if (separator_ == Separator::kComma) {
    for (std::size_t begin = 0; begin <= row.size();) {
      const std::size_t end = std::min(row.find(',', begin), row.size());
      fields_.push_back(trimmed(row.substr(begin, end - begin)));
      begin = end + 1;
    }
    return;
  }
  for (std::size_t begin = row.find_first_not_of(kBlanks); begin < row.size();) {
    const std::size_t end = std::min(row.find_first_of(kBlanks, begin), row.size());
    fields_.push_back(row.substr(begin, end - begin));
    begin = std::min(row.find_first_not_of(kBlanks, end), row.size());
  }
}

std::string_view TextRows::text(std::size_t field) {
  if (field >= fields_.size()) {
    reject("expected at least " + std::to_string(field + 1) + " fields, found " + std::to_string(fields_.size()));
    return {};
  }
  return fields_[field];
}

double TextRows::number(std::size_t field) {
  const std::string_view word = text(field);
  const std::optional<double> value = parse_number(word);
  if (!value) {
    reject(quoted(word) + " is no finite number");
  }
  return value.value_or(0.0);
}

std::int64_t TextRows::integer(std::size_t field) {
  const std::string_view word = text(field);
  const std::optional<std::int64_t> value = parse_integer(word);
  if (!value) {
    reject(quoted(word) + " is no whole number");
  }
  return value.value_or(0);
}

std::int64_t TextRows::time_ns(std::size_t field) {
  const std::string_view word = text(field);
  const std::optional<std::int64_t> value = parse_time_ns(word);
  if (!value) {
    reject(quoted(word) + " is no time; expected seconds or nanoseconds");
  }
  return value.value_or(0);
}

Se3 TextRows::pose(std::size_t field, QuaternionOrder order) {
  const Eigen::Vector3d translation(number(field), number(field + 1), number(field + 2));
  const std::size_t real = order == QuaternionOrder::kRealFirst ? field + 3 : field + 6;
  const std::size_t x = order == QuaternionOrder::kRealFirst ? field + 4 : field + 3;
  const Eigen::Quaterniond rotation(number(real), number(x), number(x + 1), number(x + 2));
  if (std::abs(rotation.norm() - 1.0) > kRotationTolerance) {
    reject("the quaternion does not have length 1");
    return {};
  }
  return {rotation.normalized().toRotationMatrix(), translation};
}

Se3 TextRows::matrix_pose(std::size_t field) {
  Eigen::Matrix<double, 3, 4> matrix;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      matrix(row, column) = number(field + static_cast<std::size_t>(row * 4 + column));
    }
  }
  const Eigen::Matrix3d rotation = matrix.leftCols<3>();
  const double off = (rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!(off < kRotationTolerance && rotation.determinant() > 0.0)) {
    reject("the 3 x 4 matrix does not begin with a rotation");
    return {};
  }
  return Se3{rotation, matrix.col(3)}.orthonormalised();
}

void TextRows::reject(const std::string& reason) {
  if (status_) {
    status_ = fail(ErrorCode::kBadFormat, path_.string() + ", line " + std::to_string(line_) + ": " + reason);
  }
}

}  // namespace kinetrace

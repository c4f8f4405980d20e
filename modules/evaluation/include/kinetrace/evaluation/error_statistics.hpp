// Mean, root mean square and maximum of a set of errors.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

namespace kinetrace::evaluation {

/// Statistics without samples are none, never zero.
class ErrorStatistics {
 public:
  /// `error` is a magnitude, not negative.
  void add(double error) noexcept {
    ++count_;
    sum_ += error;
    sum_of_squares_ += error * error;
    max_ = std::max(max_, error);
  }
  void add(const ErrorStatistics& other) noexcept {
    count_ += other.count_;
    sum_ += other.sum_;
    sum_of_squares_ += other.sum_of_squares_;
    max_ = std::max(max_, other.max_);
  }

  [[nodiscard]] std::size_t count() const noexcept { return count_; }
  [[nodiscard]] std::optional<double> mean() const noexcept { return per_count(sum_); }
  [[nodiscard]] std::optional<double> rmse() const noexcept {
    const std::optional<double> mean_square = per_count(sum_of_squares_);
    return mean_square ? std::optional(std::sqrt(*mean_square)) : std::nullopt;
  }
  [[nodiscard]] std::optional<double> max() const noexcept { return count_ > 0 ? std::optional(max_) : std::nullopt; }

 private:
  [[nodiscard]] std::optional<double> per_count(double sum) const noexcept {
    return count_ > 0 ? std::optional(sum / static_cast<double>(count_)) : std::nullopt;
  }

  std::size_t count_ = 0;
  double sum_ = 0.0;
  double sum_of_squares_ = 0.0;
  double max_ = 0.0;
};

}  // namespace kinetrace::evaluation

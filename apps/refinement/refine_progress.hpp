// Progress line with the remaining time.
#pragma once

#include <chrono>
#include <cstddef>

namespace kinetrace::batch {

/// Redrawn on standard error at most ten times a second; silent unless that is a terminal.
class RefineProgress {
 public:
  RefineProgress(bool enabled, std::size_t rows, std::size_t object_rows);

  void measured(std::size_t rows_done);
  void camera(std::size_t rows_done);
  void loops(double part);
  void objects(std::size_t rows_done);
  void written(std::size_t rows_done);
  /// Removes the line, so that other text can follow.
  void clear();

 private:
  void show(const char* doing, double part);

  using Clock = std::chrono::steady_clock;
  bool enabled_;
  bool visible_ = false;
  double rows_;
  double object_rows_;
  Clock::time_point start_ = Clock::now();
  Clock::time_point next_ = start_;
};

}  // namespace kinetrace::batch

// Guidance on the terminal during collection: which views are missing.
#pragma once

#include <chrono>
#include <string>

#include "view_collector.hpp"

namespace kinetrace::calibration {

/// "12 views | image 60 %, 55 % | 3 of 4 tilts | 0.4 to 1.1 m | next: turn the target's left edge away".
[[nodiscard]] std::string guidance_text(const Assessment& assessment, Offer newest);

/// Redraws one line on standard error; silent unless that is a terminal.
class GuidanceLine {
 public:
  explicit GuidanceLine(bool enabled);
  void show(const ViewCollector& views, Offer newest);
  void clear();

 private:
  using Clock = std::chrono::steady_clock;
  bool enabled_;
  bool visible_ = false;
  Clock::time_point next_ = Clock::now();
};

}  // namespace kinetrace::calibration

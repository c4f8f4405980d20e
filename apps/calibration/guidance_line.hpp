// Guidance on the terminal during collection: which views are missing.
#pragma once

#include <string>

#include "cli/progress.hpp"
#include "view_collector.hpp"

namespace kinetrace::calibration {

/// "12 views | image 60 %, 55 % | 3 of 4 tilts | 0.4 to 1.1 m | next: turn the target's left edge away".
[[nodiscard]] std::string guidance_text(const Assessment& assessment, Offer newest);

class GuidanceLine {
 public:
  explicit GuidanceLine(bool enabled) : line_(enabled) {}
  void show(const ViewCollector& views, Offer newest);
  void clear() { line_.clear(); }

 private:
  app::RedrawnLine line_;
};

}  // namespace kinetrace::calibration

#include "guidance_line.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

#include "cli/progress.hpp"

namespace kinetrace::calibration {

std::string guidance_text(const Assessment& assessment, Offer newest) {
  const auto tilts = std::count_if(assessment.tilted.begin(), assessment.tilted.end(), [](int n) { return n > 0; });
  std::array<char, 160> text{};
  std::snprintf(text.data(), text.size(), "%zu views | image %.0f %%, %.0f %% | %d of 4 tilts | %.2f to %.2f m | ",
                assessment.views, 100.0 * assessment.left_coverage, 100.0 * assessment.right_coverage,
                static_cast<int>(tilts), assessment.nearest_m, assessment.farthest_m);
  std::string line = text.data();
  if (newest == Offer::kNoTarget) {
    return line + "the target is not seen";
  }
  if (newest == Offer::kOneImageOnly) {
    return line + "the target is seen in one image only";
  }
  return line + (assessment.missing.empty() ? "enough" : "next: " + assessment.missing.front());
}

GuidanceLine::GuidanceLine(bool enabled) : enabled_(enabled && app::stderr_is_terminal()) {}

void GuidanceLine::show(const ViewCollector& views, Offer newest) {
  constexpr std::chrono::milliseconds kRedrawInterval(100);
  const Clock::time_point now = Clock::now();
  if (!enabled_ || now < next_) {
    return;
  }
  next_ = now + kRedrawInterval;
  visible_ = true;
  std::fprintf(stderr, "\r%s\033[K", guidance_text(views.assess(), newest).c_str());
}

void GuidanceLine::clear() {
  if (visible_) {
    std::fputs("\r\033[K", stderr);
    visible_ = false;
  }
}

}  // namespace kinetrace::calibration

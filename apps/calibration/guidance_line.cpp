#include "guidance_line.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

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

void GuidanceLine::show(const ViewCollector& views, Offer newest) {
  if (line_.is_due()) {
    std::fprintf(stderr, "\r%s\033[K", guidance_text(views.assess(), newest).c_str());
  }
}

}  // namespace kinetrace::calibration

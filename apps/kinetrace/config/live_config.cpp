#include "config/live_config.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

namespace kinetrace::app {
namespace {

Status check(const char* key, double value, double least, double most) {
  if (std::isfinite(value) && value >= least && value <= most) {
    return {};
  }
  return fail(ErrorCode::kInvalidConfig, std::string(key) + " must be in [" + std::to_string(least) + ", " +
                                             std::to_string(most) + "], got " + std::to_string(value));
}

}  // namespace

bool from_string(std::string_view text, LiveMode& mode) noexcept {
  constexpr std::array<LiveMode, 3> kModes{LiveMode::kAuto, LiveMode::kOn, LiveMode::kOff};
  const auto* const found =
      std::find_if(kModes.begin(), kModes.end(), [&](LiveMode candidate) { return to_string(candidate) == text; });
  if (found == kModes.end()) {
    return false;
  }
  mode = *found;
  return true;
}

Status LiveConfig::validate() const {
  constexpr double kMax_ms = 10'000.0;
  constexpr double kSlowest = 0.01;
  constexpr double kFastest = 100.0;
  if (Status deadline = check("live.deadline_ms", deadline_ms, 0.0, kMax_ms); !deadline) {
    return deadline;
  }
  constexpr double kMaxPriority = 99.0;
  if (Status priority = check("live.realtime_priority", realtime_priority, 0.0, kMaxPriority); !priority) {
    return priority;
  }
  return check("live.speed", speed, kSlowest, kFastest);
}

}  // namespace kinetrace::app

#include "live/load_shedder.hpp"

#include <algorithm>
#include <array>

namespace kinetrace::app {
namespace {

constexpr int kMaxRecoveryFactor = 16;

struct Level {
  int refinement_iterations;
  double points;
  double objects;  ///< Part of all.
  std::optional<HealthReason> health_reason;
};

constexpr int kAll = Effort{}.refinement_iterations;
constexpr std::array<Level, LoadShedder::kLevels> kTable{{{kAll, 1.0, 1.0, std::nullopt},
                                                          {2, 1.0, 1.0, HealthReason::kShedsIterations},
                                                          {2, 0.6, 1.0, HealthReason::kShedsPoints},
                                                          {2, 0.35, 1.0, HealthReason::kShedsPoints},
                                                          {2, 0.35, 0.5, HealthReason::kShedsObjects},
                                                          {1, 0.35, 0.25, HealthReason::kShedsObjects}}};

}  // namespace

bool LoadShedder::update(double processing_ms) noexcept {
  const int before = level_;
  late_ = processing_ms > deadline_ms_ ? late_ + 1.0 : std::max(0.0, late_ - 0.5);
  fast_frames_ =
      processing_ms < kRecoveryLoad * deadline_ms_ ? fast_frames_ + 1 : std::max(0, fast_frames_ - kSlowFrameCost);
  if (frames_since_return_) {
    ++*frames_since_return_;
  }
  if (late_ >= kMaxLateFrames && level_ + 1 < kLevels) {
    if (frames_since_return_) {
      recovery_factor_ =
          *frames_since_return_ <= kRecoveryFrames ? std::min(2 * recovery_factor_, kMaxRecoveryFactor) : 1;
      frames_since_return_.reset();
    }
    set_level(level_ + 1);
  } else if (fast_frames_ >= recovery_factor_ * kRecoveryFrames && level_ > 0) {
    set_level(level_ - 1);
    frames_since_return_ = 0;
  }
  return level_ != before;
}

void LoadShedder::set_level(int level) noexcept {
  level_ = level;
  late_ = 0.0;
  fast_frames_ = 0;
}

Effort LoadShedder::effort() const noexcept {
  const Level& level = kTable[static_cast<std::size_t>(level_)];
  if (level_ == 0) {
    return {};
  }
  return {.refinement_iterations = level.refinement_iterations,
          .points = level.points,
          .objects = std::max(1, static_cast<int>(level.objects * max_objects_))};
}

std::optional<HealthReason> LoadShedder::health_reason() const noexcept {
  return kTable[static_cast<std::size_t>(level_)].health_reason;
}

}  // namespace kinetrace::app

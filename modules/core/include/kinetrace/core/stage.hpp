// Stages of the pipeline and their observer.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "kinetrace/core/export.hpp"

namespace kinetrace {

/// Stages of processing a frame, in order.
enum class Stage : std::uint8_t {
  kCapture,
  kRectify,
  kPyramid,
  kTrackFeatures,
  kEgoMotion,
  kSegment,
  kTrackObjects,
  kReplenish,
  kSfm,
  kRefine,
  kTrajectory,
  kPublish,  ///< Queuing results; another thread sends them.
};
inline constexpr std::size_t kStageCount = 12;

[[nodiscard]] constexpr std::string_view to_string(Stage stage) noexcept {
  constexpr std::array<std::string_view, kStageCount> kNames{"capture",    "rectify", "pyramid",       "track_features",
                                                             "ego_motion", "segment", "track_objects", "replenish",
                                                             "sfm",        "refine",  "trajectory",    "publish"};
  return kNames[static_cast<std::size_t>(stage)];
}

/// Notified when stages begin and end. Modules have no clock, so the implementation does the timing.
class KINETRACE_API StageObserver {
 public:
  StageObserver() = default;
  StageObserver(const StageObserver&) = delete;
  StageObserver& operator=(const StageObserver&) = delete;
  StageObserver(StageObserver&&) = delete;
  StageObserver& operator=(StageObserver&&) = delete;
  virtual ~StageObserver() = default;
  virtual void enter(Stage stage) noexcept = 0;
  virtual void leave(Stage stage) noexcept = 0;
};

/// Reports one stage for the length of a scope. A null observer is allowed.
class StageScope {
 public:
  StageScope(StageObserver* observer, Stage stage) noexcept : observer_(observer), stage_(stage) {
    if (observer_ != nullptr) {
      observer_->enter(stage_);
    }
  }
  StageScope(const StageScope&) = delete;
  StageScope& operator=(const StageScope&) = delete;
  StageScope(StageScope&&) = delete;
  StageScope& operator=(StageScope&&) = delete;
  ~StageScope() {
    if (observer_ != nullptr) {
      observer_->leave(stage_);
    }
  }

 private:
  StageObserver* observer_;
  Stage stage_;
};

}  // namespace kinetrace

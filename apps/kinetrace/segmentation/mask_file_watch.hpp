// Reports mask files that do not fit the recording.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "camera/health_monitor.hpp"
#include "camera/input_watch.hpp"
#include "config/input_config.hpp"
#include "kinetrace/core/frame_result.hpp"

namespace kinetrace::app {

/// Warns at the first unusable mask file. The input is unusable if files exist but none fits within `kAssessed_ns`, or
/// if the whole recording has none.
class MaskFileWatch {
 public:
  static constexpr std::int64_t kAssessed_ns = 2'000'000'000;

  explicit MaskFileWatch(InputPolicy policy) : policy_(policy) {}

  /// Call after a frame. `complaint`: the first fault of a mask file; empty: none. Errors: kBadFormat (none of them can
  /// be used).
  [[nodiscard]] Status process(const FrameCounters& counters, std::int64_t timestamp_ns, std::string_view complaint,
                               HealthMonitor& health, const Warn& warn);
  /// Call after the last frame. Errors: kBadFormat (no mask was usable).
  [[nodiscard]] Status finish(std::string_view complaint, const Warn& warn) const;

 private:
  [[nodiscard]] Status none_fits(std::string_view complaint, const Warn& warn) const;

  InputPolicy policy_;
  FrameCounters last_;
  std::optional<std::int64_t> first_ns_;
  bool said_unreadable_ = false;
  bool assessed_ = false;
};

}  // namespace kinetrace::app

// Says when mask files do not fit the recording.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "camera/health_monitor.hpp"
#include "camera/input_watch.hpp"
#include "config/input_config.hpp"
#include "kinetrace/core/frame_result.hpp"

namespace kinetrace::app {

/// The first mask file that cannot be used is said at once. Where not one fits within `kAssessed_ns` though some are
/// there, or none is there in the whole recording, the input cannot be used.
class MaskFileWatch {
 public:
  static constexpr std::int64_t kAssessed_ns = 2'000'000'000;

  explicit MaskFileWatch(InputPolicy policy) : policy_(policy) {}

  /// After a frame. `complaint`: the first thing that was wrong with a mask file, empty if nothing was.
  /// Errors: kBadFormat (none of them can be used).
  [[nodiscard]] Status process(const FrameCounters& counters, std::int64_t timestamp_ns, std::string_view complaint,
                               HealthMonitor& health, const Warn& warn);
  /// After the last frame. Errors: kBadFormat (not one mask was used).
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

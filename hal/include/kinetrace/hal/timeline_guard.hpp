// Detects and corrects jumps of a clock.
#pragma once

#include <cstdint>
#include <optional>

#include "kinetrace/core/export.hpp"

namespace kinetrace::hal {

/// Checks the times of frames against independent evidence of the elapsed time: arrival times or frame numbers. A
/// contradiction means that the clock has jumped; from then on times are shifted so that they continue by the evidence.
/// Pure and deterministic.
class KINETRACE_API TimelineGuard {
 public:
  /// The evidence may be wrong by `tolerance_ns`. `must_advance`: every frame is known to be new, so that a time that
  /// does not advance is a jump, however small.
  explicit TimelineGuard(std::int64_t tolerance_ns, bool must_advance = false)
      : tolerance_ns_(tolerance_ns), must_advance_(must_advance) {}

  /// Time since the previous frame, by other evidence than its clock.
  struct Evidence {
    std::int64_t expected_ns = 0;  ///< Replaces an implausible step.
    std::int64_t shortest_ns = 0;
    std::int64_t longest_ns = 0;
  };
  struct Step {
    std::int64_t time_ns = 0;
    bool jumped = false;
  };
  /// The next frame's time.
  [[nodiscard]] Step correct(std::int64_t stamp_ns, const Evidence& evidence) noexcept;
  /// The same where the evidence is one number.
  [[nodiscard]] Step correct(std::int64_t stamp_ns, std::int64_t expected_step_ns) noexcept {
    return correct(stamp_ns, {expected_step_ns, expected_step_ns, expected_step_ns});
  }
  void reset() noexcept;

 private:
  [[nodiscard]] bool fits(std::int64_t step_ns, const Evidence& evidence) const noexcept;

  std::int64_t tolerance_ns_;
  bool must_advance_;
  std::int64_t shift_ns_ = 0;
  std::optional<std::int64_t> last_ns_;  ///< Corrected.
};

}  // namespace kinetrace::hal

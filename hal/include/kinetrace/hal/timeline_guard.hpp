// Plausible times.
#pragma once

#include <cstdint>
#include <optional>

#include "kinetrace/core/export.hpp"

namespace kinetrace::hal {

/// Checks the times of a source's frames against other evidence of how much time has passed: when they arrived, or how
/// far their numbers moved on. Where the two contradict each other the clock has jumped, and from then on times are
/// shifted so that they go on by the evidence. Pure and deterministic.
class KINETRACE_API TimelineGuard {
 public:
  /// The evidence may be wrong by `tolerance_ns`. `must_advance`: every frame is known to be new, so that a time that
  /// does not advance is a jump, however small.
  explicit TimelineGuard(std::int64_t tolerance_ns, bool must_advance = false)
      : tolerance_ns_(tolerance_ns), must_advance_(must_advance) {}

  /// How much time passed since the frame before, as far as something else than its clock can tell.
  struct Evidence {
    std::int64_t expected_ns = 0;  ///< Taken in place of a step that cannot be.
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

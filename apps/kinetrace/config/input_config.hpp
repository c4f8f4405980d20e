// Policy for unusable input.
#pragma once

#include <cstdint>
#include <string_view>

namespace kinetrace::app {

enum class InputPolicy : std::uint8_t {
  kStop,  ///< Ends the run on exchanged or identical views and on masks of which none fits.
  kWarn,  ///< Warns and continues.
};

[[nodiscard]] constexpr std::string_view to_string(InputPolicy policy) noexcept {
  return policy == InputPolicy::kStop ? "stop" : "warn";
}
[[nodiscard]] constexpr bool from_string(std::string_view text, InputPolicy& policy) noexcept {
  for (const InputPolicy candidate : {InputPolicy::kStop, InputPolicy::kWarn}) {
    if (to_string(candidate) == text) {
      policy = candidate;
      return true;
    }
  }
  return false;
}

struct InputConfig {
  InputPolicy unusable = InputPolicy::kStop;
};

template <typename Visitor>
void visit_fields(InputConfig& config, Visitor&& visit) {
  visit("input.unusable", config.unusable,
        "stop or warn: reaction to input that cannot be used (exchanged or identical views, masks of the other view, "
        "unreadable masks)");
}

}  // namespace kinetrace::app

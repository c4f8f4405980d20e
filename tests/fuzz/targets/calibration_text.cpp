// The calibration in a container's header; accepted text is read back to the same text.
#include "formats/calibration_text.hpp"

#include "fuzz_target.hpp"

void kinetrace::fuzz::try_input(std::string_view input) {
  auto rig = hal::parse_calibration_text(input, "source");
  if (!rig || !rig->validate()) {
    return;
  }
  const std::string text = hal::calibration_text(*rig);
  const auto again = hal::parse_calibration_text(text, "source");
  require(again && hal::calibration_text(*again) == text);
}

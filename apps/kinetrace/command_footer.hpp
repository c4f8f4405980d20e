// What ends the help of every command.
#pragma once

namespace kinetrace::app {

inline constexpr const char* kFooter = R"(
Exit codes: 0 done, 1 a condition of --fail-if holds or a check of doctor failed, 64 wrong command line, 65 damaged or unusable recording,
calibration or truth, 66 input not found, 70 internal error, 73 run folder cannot be made, 74 reading or writing failed,
78 wrong configuration or memory budget too small; 128 + n when signal n ended a run early (what was computed is
written).)";

}  // namespace kinetrace::app

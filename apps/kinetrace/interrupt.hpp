// SIGINT and SIGTERM as a question the main loop can ask.
#pragma once

namespace kinetrace::app {

/// From now on the first SIGINT or SIGTERM only raises a flag; a second one of the same kind ends the process as usual.
void catch_interrupts() noexcept;

/// Number of the signal that came, 0 while none has.
[[nodiscard]] int interrupted_by() noexcept;

}  // namespace kinetrace::app

// Signals that ask a program to end as a question the main loop can ask.
#pragma once

namespace kinetrace::app {

/// From now on the first signal that asks to end (Ctrl-C, SIGTERM, a terminal or connection that goes, and what timers
/// and users send: SIGINT, SIGTERM, SIGHUP, SIGALRM, SIGUSR1, SIGUSR2, SIGXCPU) only raises a flag; a second one of the
/// same kind ends the process as usual. What a parent made us ignore, such as SIGHUP by nohup, stays ignored.
void catch_interrupts() noexcept;

/// Number of the signal that came, 0 while none has.
[[nodiscard]] int interrupted_by() noexcept;

}  // namespace kinetrace::app

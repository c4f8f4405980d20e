// Termination signals as a flag that the main loop polls.
#pragma once

namespace kinetrace::app {

/// From now on the first of SIGINT (Ctrl-C), SIGTERM, SIGHUP (terminal or connection closed), SIGALRM, SIGUSR1, SIGUSR2
/// and SIGXCPU only sets a flag; a second signal of the same kind ends the process as usual. Signals that the parent
/// set to be ignored, such as SIGHUP by nohup, stay ignored.
void catch_interrupts() noexcept;

/// Number of the received signal; 0: none.
[[nodiscard]] int interrupted_by() noexcept;

}  // namespace kinetrace::app

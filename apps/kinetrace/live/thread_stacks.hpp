// Stack size of a run's threads.
#pragma once

#include <cstddef>

#include "kinetrace/core/result.hpp"

namespace kinetrace::app {

/// Stack of each thread: reserved in the memory plan and the thread's limit. Measured use: 70 to 110 KiB.
inline constexpr std::size_t kThreadStackBytes = std::size_t{256} * 1024;

/// All threads created from now on, also by libraries, get kThreadStackBytes instead of the system's 8 MiB. The main
/// thread keeps its stack. Errors: kIo if that is smaller (`ulimit -s`), or if the system refuses. No effect under a
/// sanitizer, which needs more.
[[nodiscard]] Status limit_thread_stacks();

}  // namespace kinetrace::app

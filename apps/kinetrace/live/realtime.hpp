// Real-time priority.
#pragma once

#include "kinetrace/core/result.hpp"

namespace kinetrace::app {

/// Gives the calling thread SCHED_FIFO with this priority, 1 to 99; threads that it starts later do not inherit it.
/// Errors: kIo where the system does not allow it, with the remedy.
[[nodiscard]] Status request_realtime(int priority);

}  // namespace kinetrace::app

// How much stack the threads of a run may have.
#pragma once

#include <cstddef>

#include "kinetrace/core/result.hpp"

namespace kinetrace::app {

/// Of each thread. What the memory plan sets aside, and all that a thread can get. Measured use: 70 to 110 KiB.
inline constexpr std::size_t kThreadStackBytes = std::size_t{256} * 1024;

/// Threads made from now on, by whomever, get kThreadStackBytes instead of the system's 8 MiB. The first thread keeps
/// what it has. Errors: kIo if that is less (`ulimit -s`), or if the system refuses. Nothing changes under a sanitizer,
/// which needs more.
[[nodiscard]] Status limit_thread_stacks();

}  // namespace kinetrace::app

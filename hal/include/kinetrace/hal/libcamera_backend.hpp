// Cameras through libcamera. Its ABI changes with every release; the backend is therefore a component of its own,
// kinetrace::hal_libcamera, that a program links or loads. Other programs do not need libcamera.
#pragma once

#include <string>

#include "kinetrace/core/export.hpp"
#include "kinetrace/core/result.hpp"

namespace kinetrace::hal {

/// Registers the backend kLibcamera. Call it once, before the first such camera and before starting threads: it forks a
/// small process, and libcamera runs in children of that, one for each open camera, so that a crash of libcamera costs
/// a camera and not the program. Part of kinetrace::hal_libcamera: link that.
void use_libcamera();

/// The same with the component as a plugin (`kinetrace-libcamera.so`), for programs that must also run without
/// libcamera. Never unloaded. Errors: kUnsupported (plugin or libcamera missing).
[[nodiscard]] KINETRACE_API Status load_libcamera_plugin(const std::string& path);

}  // namespace kinetrace::hal

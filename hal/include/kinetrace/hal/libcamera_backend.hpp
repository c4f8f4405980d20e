// Cameras through libcamera, whose ABI changes with every release: a component of its own, kinetrace::hal_libcamera,
// that a program links or loads, so that nobody else needs libcamera.
#pragma once

#include <string>

#include "kinetrace/core/export.hpp"
#include "kinetrace/core/result.hpp"

namespace kinetrace::hal {

/// From then on cameras with the backend kLibcamera can be opened and are listed. Called once, before the first of
/// those and before the program starts threads: it forks a small process, and libcamera runs in children of that, one
/// for each open camera, so that its crashes cost a camera and not the program. Part of kinetrace::hal_libcamera: link
/// that.
void use_libcamera();

/// The same with the component as a plugin (`kinetrace-libcamera.so`), for programs that shall run without libcamera,
/// too. Never unloaded. Errors: kUnsupported (not there, or libcamera is not).
[[nodiscard]] KINETRACE_API Status load_libcamera_plugin(const std::string& path);

}  // namespace kinetrace::hal

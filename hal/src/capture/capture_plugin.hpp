// Interface between a plugin and the program that loads it.
#pragma once

#include "capture/capture_backend.hpp"

namespace kinetrace::hal {

/// The program's register_capture_backend: the plugin has its own copy of everything else.
using RegisterCaptureBackend = void (*)(CaptureBackend backend, const CaptureBackendEntry& entry);
/// Exported by a plugin under the name kCapturePluginSymbol.
using CapturePlugin = void (*)(RegisterCaptureBackend add);
inline constexpr const char* kCapturePluginSymbol = "kinetrace_capture_plugin";

}  // namespace kinetrace::hal

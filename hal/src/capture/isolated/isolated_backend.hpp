// Runs each camera of a library that may crash or hang in a process of its own, so that only the camera is lost.
#pragma once

#include <string>

#include "capture/capture_backend.hpp"

namespace kinetrace::hal {

/// Wraps a backend so that its devices and listings run in processes of their own. Images are not copied: their buffers
/// are shared (every image needs a `dmabuf_fd`). A process that crashes or does not answer counts as an unplugged
/// device (kDisconnected) and is recovered like one. Forks: call it before starting threads. `library`: its name in
/// messages.
[[nodiscard]] CaptureBackendEntry isolate(const CaptureBackendEntry& backend, const std::string& library);

}  // namespace kinetrace::hal

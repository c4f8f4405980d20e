// Cameras of a library that may crash or hang: each lives in a process of its own, so that only the camera is lost.
#pragma once

#include <string>

#include "capture/capture_backend.hpp"

namespace kinetrace::hal {

/// The same backend, whose devices and listings are made in processes of their own. Images stay where the driver put
/// them: their buffers are shared (every image needs a `dmabuf_fd`). A process that crashes or does not answer is a
/// device that is gone (kDisconnected), taken back like one that was unplugged. Forks: call it before starting threads.
/// `library` is what messages call it.
[[nodiscard]] CaptureBackendEntry isolate(const CaptureBackendEntry& backend, const std::string& library);

}  // namespace kinetrace::hal

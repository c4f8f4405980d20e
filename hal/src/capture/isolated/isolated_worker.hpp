// The worker of an isolated capture backend: a process that serves one device, or lists all.
#pragma once

#include "capture/capture_backend.hpp"
#include "capture/isolated/packet_socket.hpp"

namespace kinetrace::hal {

/// Executes `calls` and sends images to `images` until either is closed. Then ends the process without cleaning up: a
/// foreign library may hang on an unplugged device.
[[noreturn]] void serve_device(const CaptureBackendEntry& backend, PacketSocket calls, PacketSocket images);

}  // namespace kinetrace::hal

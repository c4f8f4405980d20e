// The far side of an isolated capture backend: a process that has one device, or lists them all.
#pragma once

#include "capture/capture_backend.hpp"
#include "capture/isolated/packet_socket.hpp"

namespace kinetrace::hal {

/// Does what `calls` asks for and sends images into `images`, until either is closed. For a process of its own, which
/// ends without tidying up: what a foreign library makes of an unplugged device is not waited for.
[[noreturn]] void serve_device(const CaptureBackendEntry& backend, PacketSocket calls, PacketSocket images);

}  // namespace kinetrace::hal

// Confines the DDS library's sockets to one network interface.
#pragma once

#include "kinetrace/core/result.hpp"
#include "link/network_interface.hpp"

namespace kinetrace::publishing {

/// Cyclone DDS sends on the configured interface, but receives on all: its sockets are bound to any address. From this
/// call on the kernel drops packets to this process's sockets of DDS domain `domain` from other interfaces. Packets of
/// this machine to `allowed.ipv4` pass; they use the loopback. IPv4 UDP only: nothing else is used. Errors: kIo.
[[nodiscard]] Status confine_sockets(int domain, const InterfaceAddress& allowed);

}  // namespace kinetrace::publishing

// Keeps the DDS library's sockets to one network interface.
#pragma once

#include "kinetrace/core/result.hpp"
#include "link/network_interface.hpp"

namespace kinetrace::publishing {

/// Cyclone DDS sends on the interface that it is given, and receives on every one: its sockets are bound to any
/// address. From this call on the kernel drops what comes to this process's sockets of DDS domain `domain` by another
/// interface. Packets of this machine to `allowed.ipv4` pass, which travel by the loopback. IPv4 UDP alone: nothing
/// else is used. Errors: kIo.
[[nodiscard]] Status confine_sockets(int domain, const InterfaceAddress& allowed);

}  // namespace kinetrace::publishing

// Presence and address of a network interface.
#pragma once

#include <optional>
#include <string>

namespace kinetrace::publishing {

/// The address that a participant is bound to: any change breaks an existing participant.
struct InterfaceAddress {
  unsigned index = 0;  ///< Changes when the interface is removed and created again.
  std::string ipv4;
  bool multicast = false;

  [[nodiscard]] bool operator==(const InterfaceAddress& other) const noexcept = default;
};

/// None while the interface is missing, down, or has no IPv4 address.
[[nodiscard]] std::optional<InterfaceAddress> find_interface(const std::string& name);

/// "lo, eth0": for messages.
[[nodiscard]] std::string interface_names();

}  // namespace kinetrace::publishing

// Whether a network interface is there, and under which address.
#pragma once

#include <optional>
#include <string>

namespace kinetrace::publishing {

/// What a participant is bound to: when any of it changes, a participant made before does not work any more.
struct InterfaceAddress {
  unsigned index = 0;  ///< Another one means that the interface was removed and made again.
  std::string ipv4;
  bool multicast = false;

  [[nodiscard]] bool operator==(const InterfaceAddress& other) const noexcept = default;
};

/// None while the interface is missing, down, or has no IPv4 address.
[[nodiscard]] std::optional<InterfaceAddress> find_interface(const std::string& name);

/// "lo, eth0": for messages.
[[nodiscard]] std::string interface_names();

}  // namespace kinetrace::publishing

#include "link/network_interface.hpp"

#include <arpa/inet.h>
#include <array>
#include <ifaddrs.h>
#include <memory>
#include <net/if.h>
#include <netinet/in.h>

#include "kinetrace/core/allocation_counter.hpp"

namespace kinetrace::publishing {
namespace {

struct AddressesDeleter {
  void operator()(ifaddrs* addresses) const noexcept { freeifaddrs(addresses); }
};

std::unique_ptr<ifaddrs, AddressesDeleter> all_addresses() {
  ifaddrs* addresses = nullptr;
  return std::unique_ptr<ifaddrs, AddressesDeleter>(getifaddrs(&addresses) == 0 ? addresses : nullptr);
}

}  // namespace

std::optional<InterfaceAddress> find_interface(const std::string& name) {
  const ForeignCall foreign;  // The C library allocates a list each time.
  const auto addresses = all_addresses();
  for (const ifaddrs* entry = addresses.get(); entry != nullptr; entry = entry->ifa_next) {
    if (name != entry->ifa_name || (entry->ifa_flags & IFF_UP) == 0 || entry->ifa_addr == nullptr ||
        entry->ifa_addr->sa_family != AF_INET) {
      continue;
    }
    std::array<char, INET_ADDRSTRLEN> text{};
    const auto* address = reinterpret_cast<const sockaddr_in*>(entry->ifa_addr);
    inet_ntop(AF_INET, &address->sin_addr, text.data(), text.size());
    return InterfaceAddress{if_nametoindex(entry->ifa_name), text.data(), (entry->ifa_flags & IFF_MULTICAST) != 0};
  }
  return std::nullopt;
}

std::string interface_names() {
  std::unique_ptr<struct if_nameindex, void (*)(struct if_nameindex*)> all(if_nameindex(), if_freenameindex);
  std::string names;
  for (const struct if_nameindex* entry = all.get(); entry != nullptr && entry->if_index != 0; ++entry) {
    names += (names.empty() ? "" : ", ") + std::string(entry->if_name);
  }
  return names;
}

}  // namespace kinetrace::publishing

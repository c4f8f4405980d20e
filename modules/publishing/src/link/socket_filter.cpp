#include "link/socket_filter.hpp"

#include <arpa/inet.h>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <linux/filter.h>
#include <net/if.h>
#include <netinet/in.h>
#include <string>
#include <sys/socket.h>
#include <system_error>

#include "kinetrace/core/allocation_counter.hpp"

namespace kinetrace::publishing {
namespace {

namespace fs = std::filesystem;

// Ports of a domain: DDSI-RTPS 2.2, section 9.6.1.1.
constexpr int kFirstPort = 7400;
constexpr int kPortsOfDomain = 250;

bool is_of_domain(int socket, int domain) noexcept {
  int type = 0;
  socklen_t size = sizeof(type);
  sockaddr_in address{};
  socklen_t address_size = sizeof(address);
  if (getsockopt(socket, SOL_SOCKET, SO_TYPE, &type, &size) != 0 || type != SOCK_DGRAM ||
      getsockname(socket, reinterpret_cast<sockaddr*>(&address), &address_size) != 0 || address.sin_family != AF_INET) {
    return false;
  }
  const int port = ntohs(address.sin_port) - kFirstPort;
  return port >= 0 && port / kPortsOfDomain == domain;
}

Status attach(int socket, const InterfaceAddress& allowed) {
  constexpr std::uint32_t kInterfaceIndex = static_cast<std::uint32_t>(SKF_AD_OFF + SKF_AD_IFINDEX);
  constexpr std::uint32_t kDestination = static_cast<std::uint32_t>(SKF_NET_OFF + 16);  // In the IPv4 header.
  constexpr std::uint32_t kWholePacket = 0xFFFFFFFF;
  in_addr address{};
  inet_pton(AF_INET, allowed.ipv4.c_str(), &address);
  // Passes packets of the interface, and those of the loopback to the interface's address.
  std::array<sock_filter, 7> program{{BPF_STMT(BPF_LD | BPF_W | BPF_ABS, kInterfaceIndex),
                                      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, allowed.index, 3, 0),
                                      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, if_nametoindex("lo"), 0, 3),
                                      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, kDestination),
                                      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, ntohl(address.s_addr), 0, 1),
                                      BPF_STMT(BPF_RET | BPF_K, kWholePacket), BPF_STMT(BPF_RET | BPF_K, 0)}};
  const sock_fprog filter{program.size(), program.data()};
  if (setsockopt(socket, SOL_SOCKET, SO_ATTACH_FILTER, &filter, sizeof(filter)) != 0) {
    return fail(ErrorCode::kIo, std::string("DDS cannot be kept to one network interface (SO_ATTACH_FILTER: ") +
                                    std::strerror(errno) + "); allow this call in the process's sandbox");
  }
  return {};
}

}  // namespace

Status confine_sockets(int domain, const InterfaceAddress& allowed) {
  const ForeignCall foreign;  // The standard library allocates for each directory entry.
  std::error_code error;
  for (fs::directory_iterator entry("/proc/self/fd", error), end; !error && entry != end; entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    int socket = -1;
    std::from_chars(name.data(), name.data() + name.size(), socket);
    if (!is_of_domain(socket, domain)) {
      continue;
    }
    if (Status attached = attach(socket, allowed); !attached) {
      return attached;
    }
  }
  return error ? fail(ErrorCode::kIo, "DDS cannot be kept to one network interface: /proc/self/fd: " + error.message() +
                                          "; mount /proc")
               : Status{};
}

}  // namespace kinetrace::publishing

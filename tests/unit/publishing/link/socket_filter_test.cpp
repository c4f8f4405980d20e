#include "link/socket_filter.hpp"

#include <arpa/inet.h>
#include <array>
#include <net/if.h>
#include <netinet/in.h>
#include <string>
#include <sys/socket.h>
#include <unistd.h>

#include <gtest/gtest.h>

namespace kinetrace::publishing {
namespace {

constexpr int kDomain = 199;
constexpr int kFirstPort = 7400 + 250 * kDomain;
constexpr unsigned kNoSuchInterface = 9999;

/// A UDP socket at any address, on a free port of those given.
class Socket {
 public:
  Socket(int first_port, int ports) : fd_(socket(AF_INET, SOCK_DGRAM, 0)) {
    for (int port = first_port; port < first_port + ports; ++port) {
      const sockaddr_in address = at("0.0.0.0", port);
      if (bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0) {
        port_ = port;
        return;
      }
    }
  }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
  ~Socket() { close(fd_); }

  /// Whether a packet to this address of the machine arrives. On the loopback the kernel drops packets at once.
  [[nodiscard]] bool receives(const std::string& destination) const {
    const sockaddr_in address = at(destination, port_);
    const Socket sender(0, 1);
    EXPECT_EQ(sendto(sender.fd_, "?", 1, 0, reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 1);
    std::array<char, 2> packet{};
    return recv(fd_, packet.data(), packet.size(), MSG_DONTWAIT) == 1;
  }

 private:
  static sockaddr_in at(const std::string& ipv4, int port) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    inet_pton(AF_INET, ipv4.c_str(), &address.sin_addr);
    return address;
  }

  int fd_;
  int port_ = 0;
};

TEST(SocketFilter, PassesTheInterfaceAndWhatThisMachineSendsToItsAddress) {
  const Socket socket(kFirstPort, 100);
  ASSERT_TRUE(socket.receives("127.0.0.1") && socket.receives("127.0.0.2"));
  ASSERT_TRUE(confine_sockets(kDomain, {.index = kNoSuchInterface, .ipv4 = "127.0.0.2"}));
  EXPECT_TRUE(socket.receives("127.0.0.2"));
  EXPECT_FALSE(socket.receives("127.0.0.1"));
  ASSERT_TRUE(confine_sockets(kDomain, {.index = if_nametoindex("lo"), .ipv4 = "127.0.0.3"}));
  EXPECT_TRUE(socket.receives("127.0.0.1"));
}

TEST(SocketFilter, LeavesOtherSocketsAlone) {
  const Socket next_domain(kFirstPort + 250, 100);
  ASSERT_TRUE(confine_sockets(kDomain, {.index = kNoSuchInterface, .ipv4 = "127.0.0.2"}));
  EXPECT_TRUE(next_domain.receives("127.0.0.1"));
}

}  // namespace
}  // namespace kinetrace::publishing

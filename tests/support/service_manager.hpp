// Stands in for systemd.
#pragma once

#include <array>
#include <cstddef>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>
#include <vector>

namespace kinetrace::test {

/// Receives the notifications of services that start, or read the environment, while it exists.
class ServiceManager {
 public:
  ServiceManager() : socket_(::socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)) {
    const std::string name = "kinetrace-test-" + std::to_string(getpid());
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    name.copy(address.sun_path + 1, name.size());  // An abstract socket: no file.
    const auto bytes = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size());
    if (bind(socket_, reinterpret_cast<const sockaddr*>(&address), bytes) != 0) {
      throw std::runtime_error("cannot bind @" + name);
    }
    setenv("NOTIFY_SOCKET", ("@" + name).c_str(), 1);
  }
  ServiceManager(const ServiceManager&) = delete;
  ServiceManager& operator=(const ServiceManager&) = delete;
  ~ServiceManager() {
    close(socket_);
    for (const char* name : {"NOTIFY_SOCKET", "WATCHDOG_USEC", "WATCHDOG_PID"}) {
      unsetenv(name);
    }
  }
  /// Notifications since the last call.
  [[nodiscard]] std::vector<std::string> received() const {
    std::vector<std::string> all;
    std::array<char, 512> text{};
    for (ssize_t size = recv(socket_, text.data(), text.size(), 0); size > 0;
         size = recv(socket_, text.data(), text.size(), 0)) {
      all.emplace_back(text.data(), static_cast<std::size_t>(size));
    }
    return all;
  }

 private:
  int socket_;
};

}  // namespace kinetrace::test

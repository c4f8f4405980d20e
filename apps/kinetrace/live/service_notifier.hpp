// Notifies systemd of a supervised run's state.
#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string_view>
#include <sys/socket.h>
#include <sys/un.h>

#include "camera/health_monitor.hpp"

namespace kinetrace::app {

/// Speaks the protocol of sd_notify(3): state changes as text in a datagram to $NOTIFY_SOCKET. Without that variable
/// nothing is sent. Implemented here, as systemd's documentation suggests for programs without other uses of
/// libsystemd, which would cost a megabyte. Calls never block and never allocate. Thread-safe.
class ServiceNotifier {
 public:
  /// Reads NOTIFY_SOCKET, WATCHDOG_USEC and WATCHDOG_PID.
  ServiceNotifier() noexcept;
  ServiceNotifier(const ServiceNotifier&) = delete;
  ServiceNotifier& operator=(const ServiceNotifier&) = delete;
  ~ServiceNotifier();

  /// Reports real progress. The first call reports the service as ready; later calls feed the watchdog, at most four
  /// times per interval. `now_ns`: steady clock.
  void progress(std::int64_t now_ns) noexcept;
  /// Sends a changed condition as the status line of `systemctl status`.
  void tell(const Condition& now) noexcept;
  void stopping() noexcept { send("STOPPING=1"); }

 private:
  void send(std::string_view state) const noexcept;

  int socket_ = -1;
  sockaddr_un address_{};
  socklen_t address_bytes_ = 0;
  std::int64_t feed_every_ns_ = 0;  ///< 0: no watchdog.
  std::atomic<bool> is_ready_ = false;
  std::atomic<std::int64_t> fed_at_ns_ = 0;
  std::mutex status_mutex_;
  std::optional<Condition> notified_;
};

}  // namespace kinetrace::app

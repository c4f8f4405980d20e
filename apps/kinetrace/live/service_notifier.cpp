#include "live/service_notifier.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <unistd.h>

namespace kinetrace::app {
namespace {

std::string_view environment(const char* name) noexcept {
  const char* value = std::getenv(name);
  return value == nullptr ? std::string_view() : value;
}

std::int64_t number(std::string_view text) noexcept {
  std::int64_t value = 0;
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

/// 0 if no process, or another one, is watched.
std::int64_t watchdog_ns() noexcept {
  const std::string_view pid = environment("WATCHDOG_PID");
  return pid.empty() || number(pid) == getpid() ? number(environment("WATCHDOG_USEC")) * 1000 : 0;
}

/// STATUS=degraded: frames_outdated, sheds_points
class StatusLine {
 public:
  explicit StatusLine(const Condition& now) noexcept {
    append("STATUS=");
    append(to_string(now.state));
    std::string_view before = ": ";
    for (std::size_t i = 0; i < kHealthReasonCount; ++i) {
      if (now.reasons[i]) {
        append(before);
        append(to_string(static_cast<HealthReason>(i)));
        before = ", ";
      }
    }
  }
  [[nodiscard]] std::string_view text() const noexcept { return {text_.data(), size_}; }

 private:
  void append(std::string_view part) noexcept {
    const std::size_t count = std::min(part.size(), text_.size() - size_);
    std::copy_n(part.begin(), count, text_.begin() + static_cast<std::ptrdiff_t>(size_));
    size_ += count;
  }

  std::array<char, 512> text_{};  // All reasons at once need 240.
  std::size_t size_ = 0;
};

}  // namespace

ServiceNotifier::ServiceNotifier() noexcept : feed_every_ns_(watchdog_ns() / 4) {
  const std::string_view path = environment("NOTIFY_SOCKET");
  if (path.empty() || path.size() >= sizeof(address_.sun_path)) {
    return;
  }
  address_.sun_family = AF_UNIX;
  std::copy(path.begin(), path.end(), address_.sun_path);
  if (path.front() == '@') {
    address_.sun_path[0] = '\0';  // A name without a file.
  }
  address_bytes_ = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + path.size());
  socket_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
}

ServiceNotifier::~ServiceNotifier() {
  if (socket_ >= 0) {
    ::close(socket_);
  }
}

void ServiceNotifier::progress(std::int64_t now_ns) noexcept {
  if (socket_ < 0) {
    return;
  }
  if (!is_ready_.exchange(true)) {
    send("READY=1");
  }
  std::int64_t fed_ns = fed_at_ns_;
  // If two threads find it due, one notifies.
  if (feed_every_ns_ > 0 && now_ns - fed_ns >= feed_every_ns_ && fed_at_ns_.compare_exchange_strong(fed_ns, now_ns)) {
    send("WATCHDOG=1");
  }
}

void ServiceNotifier::tell(const Condition& now) noexcept {
  const std::lock_guard lock(status_mutex_);
  if (socket_ < 0 || notified_ == now) {
    return;
  }
  notified_ = now;
  send(StatusLine(now).text());
}

void ServiceNotifier::send(std::string_view state) const noexcept {
  if (socket_ < 0) {
    return;
  }
  // A failure to notify must not affect the run.
  [[maybe_unused]] const ssize_t sent = ::sendto(socket_, state.data(), state.size(), MSG_NOSIGNAL,
                                                 reinterpret_cast<const sockaddr*>(&address_), address_bytes_);
}

}  // namespace kinetrace::app

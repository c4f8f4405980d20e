#include "live/event_fd.hpp"

#include <cstdint>
#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

namespace kinetrace::app {

EventFd::EventFd() : fd_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {}

EventFd::~EventFd() {
  if (is_open()) {
    ::close(fd_);
  }
}

void EventFd::signal() const noexcept {
  // Fails only with 2^64 pending signals; the waiter then wakes anyway.
  constexpr std::uint64_t kOne = 1;
  [[maybe_unused]] const ssize_t written = ::write(fd_, &kOne, sizeof(kOne));
}

void EventFd::wait(int timeout_ms) const noexcept {
  pollfd waited{fd_, POLLIN, 0};
  ::poll(&waited, 1, timeout_ms);
  std::uint64_t signals = 0;
  [[maybe_unused]] const ssize_t count = ::read(fd_, &signals, sizeof(signals));
}

}  // namespace kinetrace::app

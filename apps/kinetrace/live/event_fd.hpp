// Wakes another thread without blocking.
#pragma once

namespace kinetrace::app {

/// Owns an eventfd. Signals before a wait are not lost, and count once.
class EventFd {
 public:
  EventFd();
  EventFd(const EventFd&) = delete;
  EventFd& operator=(const EventFd&) = delete;
  ~EventFd();

  /// False if the process has reached its limit of open files.
  [[nodiscard]] bool is_open() const noexcept { return fd_ >= 0; }
  void signal() const noexcept;
  /// Returns after a signal since the last call, or at the time-out.
  void wait(int timeout_ms) const noexcept;

 private:
  int fd_;
};

}  // namespace kinetrace::app

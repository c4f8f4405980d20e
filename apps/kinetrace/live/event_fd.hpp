// How one thread wakes another one without waiting for it.
#pragma once

namespace kinetrace::app {

/// A file descriptor that is closed with it. Signals before a wait are not lost, and count once.
class EventFd {
 public:
  EventFd();
  EventFd(const EventFd&) = delete;
  EventFd& operator=(const EventFd&) = delete;
  ~EventFd();

  /// False if the process may not have another open file.
  [[nodiscard]] bool is_open() const noexcept { return fd_ >= 0; }
  void signal() const noexcept;
  /// Returns after a signal since the last call, or when the time is over.
  void wait(int timeout_ms) const noexcept;

 private:
  int fd_;
};

}  // namespace kinetrace::app

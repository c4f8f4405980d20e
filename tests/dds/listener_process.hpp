// The listener, started and watched from a test.
#pragma once

#include <map>
#include <string>
#include <sys/types.h>

namespace kinetrace::test {

class ListenerProcess {
 public:
  explicit ListenerProcess(int domain);
  ListenerProcess(const ListenerProcess&) = delete;
  ListenerProcess& operator=(const ListenerProcess&) = delete;
  ~ListenerProcess();

  /// Waits until it will miss no further message; false if that takes longer than 20 s.
  [[nodiscard]] bool wait_until_matched();
  /// Stops it as a debugger would: it keeps its sockets and answers nothing.
  void freeze() const;
  void thaw() const;
  /// Ends it; messages by topic.
  [[nodiscard]] std::map<std::string, long> finish();

 private:
  [[nodiscard]] std::string read_line(int timeout_ms);

  pid_t pid_ = -1;
  int output_ = -1;
  std::string pending_;
};

}  // namespace kinetrace::test

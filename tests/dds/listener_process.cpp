#include "listener_process.hpp"

#include <array>
#include <chrono>
#include <csignal>
#include <poll.h>
#include <sstream>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

namespace kinetrace::test {

ListenerProcess::ListenerProcess(int domain) {
  std::array<int, 2> ends{};
  if (::pipe(ends.data()) != 0) {
    return;
  }
  const std::string number = std::to_string(domain);
  pid_ = ::fork();
  if (pid_ == 0) {
    ::dup2(ends[1], STDOUT_FILENO);
    ::close(ends[0]);
    ::close(ends[1]);
    ::execl(KINETRACE_LISTENER, KINETRACE_LISTENER, number.c_str(), nullptr);
    ::_exit(127);
  }
  ::close(ends[1]);
  output_ = ends[0];
}

ListenerProcess::~ListenerProcess() {
  if (pid_ > 0) {
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
  }
  if (output_ >= 0) {
    ::close(output_);
  }
}

std::string ListenerProcess::read_line(int timeout_ms) {
  for (;;) {
    if (const std::size_t end = pending_.find('\n'); end != std::string::npos) {
      std::string line = pending_.substr(0, end);
      pending_.erase(0, end + 1);
      return line;
    }
    pollfd waited{output_, POLLIN, 0};
    std::array<char, 512> buffer{};
    if (::poll(&waited, 1, timeout_ms) <= 0) {
      return "";
    }
    const ssize_t size = ::read(output_, buffer.data(), buffer.size());
    if (size <= 0) {
      return "";
    }
    pending_.append(buffer.data(), static_cast<std::size_t>(size));
  }
}

bool ListenerProcess::wait_until_matched() {
  constexpr int kTimeout_ms = 20'000;
  return read_line(kTimeout_ms) == "matched";
}

void ListenerProcess::freeze() const {
  ::kill(pid_, SIGSTOP);
}

void ListenerProcess::thaw() const {
  ::kill(pid_, SIGCONT);
}

std::map<std::string, long> ListenerProcess::finish() {
  constexpr int kTimeout_ms = 10'000;
  // The last messages are still in transit.
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  ::kill(pid_, SIGTERM);
  std::map<std::string, long> messages;
  for (std::string line = read_line(kTimeout_ms); !line.empty(); line = read_line(kTimeout_ms)) {
    std::istringstream fields(line);
    std::string topic;
    fields >> topic >> messages[topic];
  }
  ::waitpid(pid_, nullptr, 0);
  pid_ = -1;
  return messages;
}

}  // namespace kinetrace::test

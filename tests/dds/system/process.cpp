#include "process.hpp"

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>
#include <utility>

#include "program.hpp"

namespace kinetrace::test {
namespace {

std::string text_of(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

std::string unique_path(const char* stem) {
  static std::atomic<int> count{0};
  return (std::filesystem::temp_directory_path() /
          ("kinetrace-dds-" + std::to_string(getpid()) + "-" + std::to_string(++count) + stem))
      .string();
}

/// The line before the last end of line.
std::string last_line(const std::string& path) {
  const std::string text = text_of(path);
  const std::size_t end = text.rfind('\n');
  if (end == std::string::npos || end == 0) {
    return "";
  }
  const std::size_t begin = text.rfind('\n', end - 1);
  return text.substr(begin == std::string::npos ? 0 : begin + 1, end - (begin == std::string::npos ? 0 : begin + 1));
}

}  // namespace

Process::Process(std::vector<std::string> command) : out_path_(unique_path(".out")), err_path_(unique_path(".err")) {
  pid_ = start_program(std::move(command), out_path_, err_path_);
  is_running_ = true;
}

Process::~Process() {
  if (is_running_) {
    send(SIGKILL);
    wait();
  }
  std::remove(out_path_.c_str());
  std::remove(err_path_.c_str());
}

void Process::send(int signal) const {
  kill(pid_, signal);
}

int Process::wait() {
  is_running_ = false;
  return await_end(pid_);
}

int Process::stop() {
  send(SIGTERM);
  return wait();
}

nlohmann::json Process::report() const {
  const nlohmann::json line = nlohmann::json::parse(last_line(out_path_), nullptr, false);
  return line.is_discarded() ? nlohmann::json() : line;
}

bool Process::has_ended() const {
  siginfo_t ended{};
  return waitid(P_PID, static_cast<id_t>(pid_), &ended, WEXITED | WNOHANG | WNOWAIT) == 0 && ended.si_pid != 0;
}

bool Process::wait_for(const std::function<bool()>& is_so) const {
  constexpr auto kFarTooLong = std::chrono::seconds(60);
  constexpr auto kPause = std::chrono::milliseconds(20);
  const auto end = std::chrono::steady_clock::now() + kFarTooLong;
  while (std::chrono::steady_clock::now() < end) {
    const bool is_last_look = has_ended();  // Before reading, so that its last output counts.
    if (is_so()) {
      return true;
    }
    if (is_last_look) {
      return false;
    }
    std::this_thread::sleep_for(kPause);
  }
  return false;
}

bool Process::until(const Condition& condition) const {
  return wait_for([&] {
    const nlohmann::json line = report();
    return !line.is_null() && condition(line);
  });
}

bool Process::until_err(const std::string& text) const {
  return wait_for([&] { return err().find(text) != std::string::npos; });
}

std::string Process::err() const {
  return text_of(err_path_);
}

std::string Process::out() const {
  return text_of(out_path_);
}

std::uint64_t Process::resident_kib() const {
  std::ifstream file("/proc/" + std::to_string(pid_) + "/smaps_rollup");
  for (std::string line; std::getline(file, line);) {
    if (line.rfind("Rss:", 0) == 0) {
      return std::stoull(line.substr(4));
    }
  }
  return 0;
}

Process::Condition at_least(const std::string& name, std::int64_t value) {
  return [name, value](const nlohmann::json& report) { return report.at(name).get<std::int64_t>() >= value; };
}

Ending run_to_end(std::vector<std::string> command) {
  Process process(std::move(command));
  const int code = process.wait();
  return {code, process.out(), process.err()};
}

}  // namespace kinetrace::test

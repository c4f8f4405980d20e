#include "process.hpp"

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <spawn.h>
#include <sstream>
#include <stdexcept>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

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

int exit_code(int status) {
  constexpr int kSignalBase = 128;
  return WIFEXITED(status) ? WEXITSTATUS(status) : kSignalBase + WTERMSIG(status);
}

}  // namespace

Process::Process(std::vector<std::string> command) : out_path_(unique_path(".out")), err_path_(unique_path(".err")) {
  std::vector<char*> argv;
  for (std::string& argument : command) {
    argv.push_back(argument.data());
  }
  argv.push_back(nullptr);
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  constexpr int kCreate = O_WRONLY | O_CREAT | O_TRUNC;
  posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, out_path_.c_str(), kCreate, 0600);
  posix_spawn_file_actions_addopen(&files, STDERR_FILENO, err_path_.c_str(), kCreate, 0600);
  const int error = posix_spawnp(&pid_, argv[0], &files, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  if (error != 0) {
    throw std::runtime_error("cannot start " + command[0]);
  }
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
  int status = 0;
  waitpid(pid_, &status, 0);
  is_running_ = false;
  return exit_code(status);
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
    const bool is_last_look = has_ended();  // Before looking: what it wrote at its end counts.
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

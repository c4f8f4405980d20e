// Programs that run beside a test and report in JSON lines.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <sys/types.h>
#include <vector>

#include <nlohmann/json.hpp>

namespace kinetrace::test {

/// A started program; killed at the latest by the destructor.
class Process {
 public:
  using Condition = std::function<bool(const nlohmann::json&)>;

  explicit Process(std::vector<std::string> command);
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;
  Process(Process&&) = delete;
  Process& operator=(Process&&) = delete;
  ~Process();

  void send(int signal) const;
  /// Exit code, or 128 + n if signal n killed it.
  int wait();
  [[nodiscard]] pid_t pid() const noexcept { return pid_; }
  /// SIGTERM and `wait`.
  int stop();

  /// The newest complete line of its standard output; null before the first.
  [[nodiscard]] nlohmann::json report() const;
  /// Waits until `condition(report())`; false after a generous time-out, or if the program has ended without.
  [[nodiscard]] bool until(const Condition& condition) const;
  /// The same for a text in its standard error.
  [[nodiscard]] bool until_err(const std::string& text) const;
  /// Its standard error so far.
  [[nodiscard]] std::string err() const;
  /// Its standard output so far.
  [[nodiscard]] std::string out() const;
  [[nodiscard]] std::uint64_t resident_kib() const;

 private:
  [[nodiscard]] bool has_ended() const;
  [[nodiscard]] bool wait_for(const std::function<bool()>& is_so) const;

  std::string out_path_;
  std::string err_path_;
  pid_t pid_ = -1;
  bool is_running_ = false;
};

/// Condition: `report[name]` is at least `value`.
[[nodiscard]] Process::Condition at_least(const std::string& name, std::int64_t value);

/// Exit of a program that ends by itself.
struct Ending {
  int exit_code = -1;
  std::string out;
  std::string err;
};
[[nodiscard]] Ending run_to_end(std::vector<std::string> command);

}  // namespace kinetrace::test

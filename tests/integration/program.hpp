// Runs the built kinetrace as a user would.
#pragma once

#include <filesystem>
#include <string>
#include <sys/types.h>
#include <vector>

#include "control_group.hpp"

namespace kinetrace::test {

// Exit codes, after sysexits.h.
inline constexpr int kUsage = 64;
inline constexpr int kBadData = 65;
inline constexpr int kNoInput = 66;
inline constexpr int kCannotCreate = 73;
inline constexpr int kIo = 74;
inline constexpr int kConfig = 78;

/// Starts `command`, whose program may be in the PATH, with its output in these files. Throws on failure.
[[nodiscard]] pid_t start_program(std::vector<std::string> command, const std::string& out_path,
                                  const std::string& err_path);
/// Waits for the end of a process: its exit code, or 128 + n if signal n killed it.
[[nodiscard]] int await_end(pid_t pid);

struct ProgramResult {
  int exit_code = -1;  ///< 128 + n if signal n killed it.
  std::string out;
  std::string err;
};

/// A started kinetrace; its output goes to files until it is waited for.
class Program {
 public:
  /// `group`: limits of the process; null: none.
  explicit Program(const std::vector<std::string>& arguments, const ControlGroup* group = nullptr);
  void send(int signal) const;
  [[nodiscard]] pid_t pid() const noexcept { return pid_; }
  [[nodiscard]] ProgramResult wait();

 private:
  std::string out_path_;
  std::string err_path_;
  pid_t pid_ = -1;
};

[[nodiscard]] inline ProgramResult run_kinetrace(const std::vector<std::string>& arguments,
                                                 const ControlGroup* group = nullptr) {
  return Program(arguments, group).wait();
}

/// A line of bash, in which $kinetrace stands for the program.
[[nodiscard]] ProgramResult run_in_shell(const std::string& line);

/// Expects that the program refused to work: this exit code, nothing on standard output, and one line on standard
/// error, which holds `culprit`.
void expect_refusal(const ProgramResult& result, int exit_code, const std::string& culprit);

/// Content of a file; empty if there is none.
[[nodiscard]] std::string text_of(const std::filesystem::path& path);

/// Allocations after the start according to `run.json` or another report; 0 in a sanitized program, which does not
/// count them.
template <typename Json>
[[nodiscard]] int allocations_after_start(const Json& report) {
  const auto& counted = report.at("allocations_after_start");
#ifdef KINETRACE_SANITIZED
  return counted.is_null() ? 0 : counted.template get<int>();
#else
  return counted.template get<int>();
#endif
}

}  // namespace kinetrace::test

// Runs the built kinetrace as a user would.
#pragma once

#include <string>
#include <sys/types.h>
#include <vector>

namespace kinetrace::test {

/// Starts `command`, whose program may be one of the PATH, with its output in these files. Throws where that fails.
[[nodiscard]] pid_t start_program(std::vector<std::string> command, const std::string& out_path,
                                  const std::string& err_path);
/// Waits for its end: the exit code, or 128 + n if signal n killed it.
[[nodiscard]] int await_end(pid_t pid);

struct ProgramResult {
  int exit_code = -1;  ///< 128 + n if signal n killed it.
  std::string out;
  std::string err;
};

/// A started kinetrace; its output goes to files until it is waited for.
class Program {
 public:
  explicit Program(const std::vector<std::string>& arguments);
  void send(int signal) const;
  [[nodiscard]] ProgramResult wait();

 private:
  std::string out_path_;
  std::string err_path_;
  pid_t pid_ = -1;
};

[[nodiscard]] inline ProgramResult run_kinetrace(const std::vector<std::string>& arguments) {
  return Program(arguments).wait();
}

}  // namespace kinetrace::test

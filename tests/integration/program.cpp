#include "program.hpp"

#include <csignal>
#include <cstdio>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <spawn.h>
#include <sstream>
#include <stdexcept>
#include <sys/wait.h>
#include <unistd.h>

namespace kinetrace::test {
namespace {

std::string take_file(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  std::remove(path.c_str());
  return text.str();
}

std::string unique_path(const char* stem) {
  static int count = 0;
  const std::string name = "kinetrace-test-" + std::to_string(getpid()) + "-" + std::to_string(++count) + stem;
  return (std::filesystem::temp_directory_path() / name).string();
}

}  // namespace

Program::Program(const std::vector<std::string>& arguments)
    : out_path_(unique_path(".out")), err_path_(unique_path(".err")) {
  std::string program = KINETRACE_PROGRAM;
  std::vector<char*> argv{program.data()};
  std::vector<std::string> copies = arguments;
  for (std::string& argument : copies) {
    argv.push_back(argument.data());
  }
  argv.push_back(nullptr);
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  constexpr int kCreate = O_WRONLY | O_CREAT | O_TRUNC;
  posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, out_path_.c_str(), kCreate, 0600);
  posix_spawn_file_actions_addopen(&files, STDERR_FILENO, err_path_.c_str(), kCreate, 0600);
  const int error = posix_spawn(&pid_, program.c_str(), &files, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  if (error != 0) {
    throw std::runtime_error("cannot start " + program);
  }
}

void Program::send(int signal) const {
  kill(pid_, signal);
}

ProgramResult Program::wait() {
  int status = 0;
  waitpid(pid_, &status, 0);
  return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), take_file(out_path_), take_file(err_path_)};
}

}  // namespace kinetrace::test

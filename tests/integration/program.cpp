#include "program.hpp"

#include <algorithm>
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
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace kinetrace::test {
namespace {

std::string take_file(const std::string& path) {
  std::string text = text_of(path);
  std::remove(path.c_str());
  return text;
}

std::string unique_path(const char* stem) {
  static int count = 0;
  const std::string name = "kinetrace-test-" + std::to_string(getpid()) + "-" + std::to_string(++count) + stem;
  return (std::filesystem::temp_directory_path() / name).string();
}

}  // namespace

pid_t start_program(std::vector<std::string> command, const std::string& out_path, const std::string& err_path) {
  std::vector<char*> argv;
  argv.reserve(command.size() + 1);
  for (std::string& argument : command) {
    argv.push_back(argument.data());
  }
  argv.push_back(nullptr);
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  constexpr int kCreate = O_WRONLY | O_CREAT | O_TRUNC;
  posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, out_path.c_str(), kCreate, 0600);
  posix_spawn_file_actions_addopen(&files, STDERR_FILENO, err_path.c_str(), kCreate, 0600);
  pid_t pid = -1;
  const int error = posix_spawnp(&pid, argv[0], &files, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  if (error != 0) {
    throw std::runtime_error("cannot start " + command[0]);
  }
  return pid;
}

int await_end(pid_t pid) {
  constexpr int kSignalBase = 128;
  int status = 0;
  waitpid(pid, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : kSignalBase + WTERMSIG(status);
}

Program::Program(const std::vector<std::string>& arguments, const ControlGroup* group)
    : out_path_(unique_path(".out")), err_path_(unique_path(".err")) {
  std::vector<std::string> command{KINETRACE_PROGRAM};
  command.insert(command.end(), arguments.begin(), arguments.end());
  pid_ = start_program(group == nullptr ? std::move(command) : group->around(command), out_path_, err_path_);
}

void Program::send(int signal) const {
  kill(pid_, signal);
}

ProgramResult Program::wait() {
  const int exit_code = await_end(pid_);
  return {exit_code, take_file(out_path_), take_file(err_path_)};
}

ProgramResult run_in_shell(const std::string& line) {
  const std::string out = unique_path(".out");
  const std::string err = unique_path(".err");
  const int exit_code = await_end(start_program({"bash", "-c", "kinetrace=" KINETRACE_PROGRAM "; " + line}, out, err));
  return {exit_code, take_file(out), take_file(err)};
}

void expect_refusal(const ProgramResult& result, int exit_code, const std::string& culprit) {
  EXPECT_EQ(result.exit_code, exit_code) << result.err;
  EXPECT_EQ(result.out, "");
  EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  EXPECT_EQ(result.err.rfind("kinetrace: error: ", 0), 0U) << result.err;
  EXPECT_THAT(result.err, ::testing::HasSubstr(culprit));
}

std::string text_of(const std::filesystem::path& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

}  // namespace kinetrace::test

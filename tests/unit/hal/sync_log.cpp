#include "sync_log.hpp"

#include <filesystem>
#include <sys/syscall.h>
#include <unistd.h>
#include <utility>

namespace kinetrace::hal::test {
namespace {

std::vector<std::pair<std::string, std::string>>& calls() {
  static std::vector<std::pair<std::string, std::string>> all;
  return all;
}

int pass_on(const char* kind, long call, int fd) {
  calls().emplace_back(kind, std::filesystem::read_symlink("/proc/self/fd/" + std::to_string(fd)).string());
  return static_cast<int>(syscall(call, fd));
}

}  // namespace

std::vector<std::pair<std::string, std::string>> take_syncs() {
  return std::exchange(calls(), {});
}

}  // namespace kinetrace::hal::test

// Replace the C library's functions.
extern "C" {
int fsync(int fd) {
  return kinetrace::hal::test::pass_on("file", SYS_fsync, fd);
}
int fdatasync(int fd) {
  return kinetrace::hal::test::pass_on("data", SYS_fdatasync, fd);
}
int syncfs(int fd) noexcept {
  return kinetrace::hal::test::pass_on("disk", SYS_syncfs, fd);
}
}

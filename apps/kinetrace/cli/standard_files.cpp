#include "cli/standard_files.hpp"

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <unistd.h>

namespace kinetrace::app {

void prepare_standard_files() noexcept {
  int file = open("/dev/null", O_RDONLY);
  while (file >= 0 && file <= STDERR_FILENO) {
    file = open("/dev/null", O_RDONLY);
  }
  if (file > STDERR_FILENO) {
    close(file);
  }
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
}

std::optional<std::string> output_failure() {
  errno = 0;
  const bool is_written = std::fflush(stdout) == 0 && std::ferror(stdout) == 0;
  if (is_written) {
    return std::nullopt;
  }
  std::string why = errno == 0 ? "" : " (" + std::string(std::strerror(errno)) + ")";
  return "standard output: cannot be written" + why + "; what was printed is not complete";
}

}  // namespace kinetrace::app

#include "fake_disk.hpp"

#include <csignal>
#include <sys/statvfs.h>
#include <utility>

namespace kinetrace::hal::test {
namespace {

const FakeDisk*& current() {
  static const FakeDisk* disk = nullptr;
  return disk;
}

}  // namespace

FakeDisk::FakeDisk(std::filesystem::path folder, std::uint64_t bytes) : folder_(std::move(folder)), bytes_(bytes) {
  current() = this;
}

FakeDisk::~FakeDisk() {
  current() = nullptr;
}

std::uint64_t FakeDisk::free_bytes() const {
  std::uint64_t used = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_)) {
    used += entry.is_regular_file() ? entry.file_size() : 0;
  }
  return used < bytes_ ? bytes_ - used : 0;
}

FileSizeLimit::FileSizeLimit(rlim_t bytes) {
  getrlimit(RLIMIT_FSIZE, &before_);
  handler_ = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit limit{bytes, before_.rlim_max};
  setrlimit(RLIMIT_FSIZE, &limit);
}

FileSizeLimit::~FileSizeLimit() {
  setrlimit(RLIMIT_FSIZE, &before_);
  static_cast<void>(std::signal(SIGXFSZ, handler_));
}

}  // namespace kinetrace::hal::test

// Replaces the C library's function.
extern "C" int statvfs(const char* path, struct statvfs* disk) noexcept {
  struct statvfs64 real {};
  const int code = statvfs64(path, &real);
  const auto* fake = kinetrace::hal::test::current();
  disk->f_frsize = fake != nullptr ? 1 : real.f_frsize;
  disk->f_bavail = fake != nullptr ? fake->free_bytes() : real.f_bavail;
  return code;
}

// Disks that are full: of a known size, as far as statvfs() tells, or that take no more.
#pragma once

#include <cstdint>
#include <filesystem>
#include <sys/resource.h>

namespace kinetrace::hal::test {

/// While it lives, every disk has so many bytes, less what the files below `folder` take.
class FakeDisk {
 public:
  FakeDisk(std::filesystem::path folder, std::uint64_t bytes);
  FakeDisk(const FakeDisk&) = delete;
  FakeDisk& operator=(const FakeDisk&) = delete;
  ~FakeDisk();

  [[nodiscard]] std::uint64_t free_bytes() const;

 private:
  std::filesystem::path folder_;
  std::uint64_t bytes_;
};

/// While it lives, no file may grow beyond so much, as on a disk that is full: writes come back short, then fail.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes);
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;
  ~FileSizeLimit();

 private:
  rlimit before_{};
  void (*handler_)(int) = nullptr;
};

}  // namespace kinetrace::hal::test

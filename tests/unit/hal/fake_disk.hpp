// Full disks: of a known size according to statvfs(), or that accept no more data.
#pragma once

#include <cstdint>
#include <filesystem>
#include <sys/resource.h>

namespace kinetrace::hal::test {

/// While it exists, every disk has this many bytes, minus the size of the files below `folder`.
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

/// While it exists, no file may grow beyond this size, as on a full disk: writes come back short, then fail.
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

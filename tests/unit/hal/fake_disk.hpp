// A disk of a known size, as far as statvfs() tells.
#pragma once

#include <cstdint>
#include <filesystem>

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

}  // namespace kinetrace::hal::test

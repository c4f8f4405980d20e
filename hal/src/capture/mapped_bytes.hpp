// A read-only mapping of a part of a device's memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <sys/mman.h>
#include <utility>

namespace kinetrace::hal {

class MappedBytes {
 public:
  /// Sets errno if it is not valid() afterwards.
  MappedBytes(int fd, std::size_t length, std::int64_t offset) noexcept {
    void* address = mmap(nullptr, length, PROT_READ, MAP_SHARED, fd, offset);
    if (address != MAP_FAILED) {
      bytes_ = {static_cast<const std::byte*>(address), length};
    }
  }
  MappedBytes(MappedBytes&& other) noexcept : bytes_(std::exchange(other.bytes_, {})) {}
  MappedBytes& operator=(MappedBytes&&) = delete;
  MappedBytes(const MappedBytes&) = delete;
  MappedBytes& operator=(const MappedBytes&) = delete;
  ~MappedBytes() {
    if (!bytes_.empty()) {
      munmap(const_cast<std::byte*>(bytes_.data()), bytes_.size());
    }
  }

  [[nodiscard]] bool valid() const noexcept { return !bytes_.empty(); }
  [[nodiscard]] std::span<const std::byte> bytes() const noexcept { return bytes_; }

 private:
  std::span<const std::byte> bytes_;
};

}  // namespace kinetrace::hal

// Input files: regular ones only. Reading a named pipe or a device instead could block or never end.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "kinetrace/core/export.hpp"
#include "kinetrace/core/in_place_error.hpp"
#include "kinetrace/core/result.hpp"

namespace kinetrace {

/// Limit for files that are read whole; every file of Kinetrace is smaller.
inline constexpr std::size_t kMaxFileBytes = std::size_t{1} << 31U;

/// An open regular file, closed on destruction. Opening never waits and never allocates.
class KINETRACE_API InputFile {
 public:
  /// Errors, naming the file: kNotFound, kIo, kBadFormat (a folder, a named pipe, a socket or a device).
  [[nodiscard]] static InPlaceResult<InputFile> open(const char* path);
  /// The whole content of a file. Errors: as open; kBadFormat beyond `max_bytes`, before any memory is taken; kIo.
  [[nodiscard]] static Result<std::string> read_whole(const std::filesystem::path& path,
                                                      std::size_t max_bytes = kMaxFileBytes);
  InputFile(InputFile&& other) noexcept;
  InputFile& operator=(InputFile&&) = delete;
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;
  ~InputFile();

  /// Size when it was opened.
  [[nodiscard]] std::size_t size_bytes() const noexcept { return size_bytes_; }
  [[nodiscard]] int descriptor() const noexcept { return descriptor_; }
  /// Bytes read from `offset`, fewer than asked for at the end of the file or on a read error.
  [[nodiscard]] std::size_t read(std::size_t offset, std::span<std::uint8_t> target) const noexcept;

 private:
  InputFile(int descriptor, std::size_t size_bytes) : descriptor_(descriptor), size_bytes_(size_bytes) {}
  int descriptor_ = -1;
  std::size_t size_bytes_ = 0;
};

}  // namespace kinetrace

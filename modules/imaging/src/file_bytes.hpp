// Files as bytes, without the heap.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "kinetrace/core/result.hpp"

namespace kinetrace::imaging {

/// An open regular file, closed on destruction.
class InputFile {
 public:
  /// Errors: kNotFound, kIo, kBadFormat (empty or not a regular file).
  [[nodiscard]] static Result<InputFile> open(const char* path);
  InputFile(InputFile&& other) noexcept;
  InputFile& operator=(InputFile&&) = delete;
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;
  ~InputFile();

  [[nodiscard]] std::size_t size_bytes() const noexcept { return size_bytes_; }
  /// Bytes read from `offset`, fewer than asked for at the end of the file or on a read error.
  [[nodiscard]] std::size_t read(std::size_t offset, std::span<std::uint8_t> target) const noexcept;

 private:
  InputFile(int descriptor, std::size_t size_bytes) : descriptor_(descriptor), size_bytes_(size_bytes) {}
  int descriptor_ = -1;
  std::size_t size_bytes_ = 0;
};

/// "PATH: WHAT", as every error about a file begins.
[[nodiscard]] Unexpected<Error> file_error(ErrorCode code, const char* path, std::string_view what);

}  // namespace kinetrace::imaging

// Files on plain file descriptors with buffers from the arena: no allocation while writing; every error is reported.
#pragma once

#include <charconv>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <type_traits>
#include <utility>

#include "kinetrace/core/result.hpp"

namespace kinetrace::recording {

/// A file descriptor that is closed when it goes out of scope.
class FileHandle {
 public:
  FileHandle() = default;
  explicit FileHandle(int descriptor) noexcept : descriptor_(descriptor) {}
  FileHandle(FileHandle&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  FileHandle& operator=(FileHandle&& other) noexcept {
    std::swap(descriptor_, other.descriptor_);
    return *this;
  }
  FileHandle(const FileHandle&) = delete;
  FileHandle& operator=(const FileHandle&) = delete;
  ~FileHandle();

  [[nodiscard]] int get() const noexcept { return descriptor_; }
  [[nodiscard]] bool is_open() const noexcept { return descriptor_ >= 0; }
  /// Closes; returns 0 or the error number.
  [[nodiscard]] int close() noexcept;

 private:
  int descriptor_ = -1;
};

enum class OpenMode { kRead, kFolder, kCreate, kUpdate };

/// Opens `path`; kRead takes regular files only and never waits, kFolder opens a folder, kCreate truncates. The error
/// names the file and the reason.
[[nodiscard]] Result<FileHandle> open_file(const std::filesystem::path& path, OpenMode mode);
[[nodiscard]] Result<std::uint64_t> file_size(const FileHandle& file, const std::filesystem::path& path);
/// Whole reads and writes at an offset; a short one is an error.
[[nodiscard]] Status read_at(const FileHandle& file, std::uint64_t offset, std::span<std::byte> bytes,
                             const std::filesystem::path& path);
[[nodiscard]] Status write_at(const FileHandle& file, std::uint64_t offset, std::span<const std::byte> bytes,
                              const std::filesystem::path& path);
/// The one-line error of a failed file operation.
[[nodiscard]] Unexpected<Error> file_error(std::string_view operation, const std::filesystem::path& path,
                                           int error_number);

/// Appends text or records to a file through a buffer it does not own. The first error sticks: later appends do nothing
/// and `status()`, `flush()` and `close()` report it. A default-constructed writer is switched off and ignores appends.
class BufferedWriter {
 public:
  BufferedWriter() = default;
  /// `buffer` holds at least kMinBufferBytes and outlives the writer.
  [[nodiscard]] static Result<BufferedWriter> create(std::filesystem::path path, std::span<std::byte> buffer);

  static constexpr std::size_t kMaxNumberChars = 384;  ///< Longest number: 1e308 in fixed notation and its decimals.
  static constexpr std::size_t kMinBufferBytes = 2 * kMaxNumberChars;

  BufferedWriter& bytes(std::span<const std::byte> data) noexcept;
  BufferedWriter& text(std::string_view characters) noexcept { return bytes(std::as_bytes(std::span(characters))); }
  template <typename Record>
  requires std::is_trivially_copyable_v<Record> BufferedWriter& record(const Record& value) noexcept {
    return bytes(std::as_bytes(std::span(&value, 1)));
  }
  template <std::integral Integer>
  BufferedWriter& integer(Integer value) noexcept {
    return number(value);
  }
  /// `decimals` digits after the point, whatever the locale.
  BufferedWriter& fixed(double value, int decimals) noexcept {
    return number(value, std::chars_format::fixed, decimals);
  }
  /// `digits` significant digits, with an exponent where that is shorter.
  BufferedWriter& general(double value, int digits) noexcept {
    return number(value, std::chars_format::general, digits);
  }

  [[nodiscard]] bool is_open() const noexcept { return file_.is_open(); }
  [[nodiscard]] bool failed() const noexcept { return error_number_ != 0; }
  [[nodiscard]] Status status() const;
  [[nodiscard]] Status flush();
  [[nodiscard]] Status close();

 private:
  template <typename... Format>
  BufferedWriter& number(Format... format) noexcept {
    if (!file_.is_open()) {
      return *this;
    }
    if (buffer_.size() - used_ < kMaxNumberChars) {
      drain();
    }
    char* first = reinterpret_cast<char*>(buffer_.data()) + used_;
    const std::to_chars_result end = std::to_chars(first, first + kMaxNumberChars, format...);
    used_ += static_cast<std::size_t>(end.ptr - first);
    return *this;
  }
  void drain() noexcept;

  std::filesystem::path path_;
  FileHandle file_;
  std::span<std::byte> buffer_;
  std::size_t used_ = 0;
  int error_number_ = 0;
};

}  // namespace kinetrace::recording

// Reads a spool file record by record through a buffer it does not own.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <span>
#include <type_traits>

#include "buffered_file.hpp"

namespace kinetrace::recording {

/// Records [first, last) of an open file, untyped: the part that does not depend on the record.
class SpoolCursor {
 public:
  SpoolCursor(const FileHandle& file, const std::filesystem::path& path, std::size_t record_bytes,
              std::span<std::byte> buffer) noexcept
      : file_(&file), path_(&path), record_bytes_(record_bytes), buffer_(buffer) {}

  void set_range(std::uint64_t first, std::uint64_t last) noexcept {
    next_ = first;
    last_ = last;
  }
  [[nodiscard]] std::uint64_t position() const noexcept { return next_; }
  void advance() noexcept { ++next_; }
  /// The record at the position, nullptr at the end of the range or after an error. Valid until the next call.
  [[nodiscard]] const std::byte* peek();
  [[nodiscard]] const Status& status() const noexcept { return status_; }

 private:
  const FileHandle* file_;
  const std::filesystem::path* path_;
  std::size_t record_bytes_;
  std::span<std::byte> buffer_;
  std::uint64_t next_ = 0;
  std::uint64_t last_ = 0;
  std::uint64_t buffered_first_ = 0;  ///< Records [buffered_first_, buffered_last_) are in the buffer.
  std::uint64_t buffered_last_ = 0;
  Status status_;
};

template <typename Record>
class RecordCursor {
 public:
  static_assert(std::is_trivially_copyable_v<Record>);
  RecordCursor(const FileHandle& file, const std::filesystem::path& path, std::span<std::byte> buffer) noexcept
      : cursor_(file, path, sizeof(Record), buffer) {}
  void set_range(std::uint64_t first, std::uint64_t last) noexcept { cursor_.set_range(first, last); }
  [[nodiscard]] std::uint64_t position() const noexcept { return cursor_.position(); }
  [[nodiscard]] const Record* peek() { return reinterpret_cast<const Record*>(cursor_.peek()); }
  void advance() noexcept { cursor_.advance(); }
  [[nodiscard]] const Status& status() const noexcept { return cursor_.status(); }

 private:
  SpoolCursor cursor_;
};

/// A spool file opened for reading from its beginning. Not movable: its cursor refers to it.
template <typename Record>
class SpoolFile {
 public:
  SpoolFile(std::filesystem::path path, std::span<std::byte> buffer)
      : path_(std::move(path)), cursor_(file_, path_, buffer) {}
  SpoolFile(const SpoolFile&) = delete;
  SpoolFile& operator=(const SpoolFile&) = delete;

  [[nodiscard]] Status open() {
    Result<FileHandle> file = open_file(path_, OpenMode::kRead);
    if (!file) {
      return Unexpected(file.error());
    }
    file_ = std::move(*file);
    const Result<std::uint64_t> bytes = file_size(file_, path_);
    if (!bytes) {
      return Unexpected(bytes.error());
    }
    size_ = *bytes / sizeof(Record);
    cursor_.set_range(0, size_);
    return {};
  }
  [[nodiscard]] std::uint64_t size() const noexcept { return size_; }
  [[nodiscard]] std::uint64_t position() const noexcept { return cursor_.position(); }
  void seek(std::uint64_t position) noexcept { cursor_.set_range(position, size_); }
  [[nodiscard]] const Record* peek() { return cursor_.peek(); }
  void advance() noexcept { cursor_.advance(); }
  [[nodiscard]] const Status& status() const noexcept { return cursor_.status(); }

 private:
  std::filesystem::path path_;
  FileHandle file_;
  std::uint64_t size_ = 0;
  RecordCursor<Record> cursor_;
};

}  // namespace kinetrace::recording

// Appends to files atomically, and makes them durable against a loss of power.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "kinetrace/core/result.hpp"
#include "util/owned_fd.hpp"

namespace kinetrace::hal {

/// Allocates only to write error messages.
class AppendFile {
 public:
  AppendFile() = default;
  /// Creates the file. Errors: kIo (exists already, no permission, disk full).
  [[nodiscard]] static Result<AppendFile> create(const char* path);

  [[nodiscard]] bool valid() const noexcept { return file_.valid(); }
  [[nodiscard]] std::uint64_t bytes() const noexcept { return bytes_; }
  /// All or nothing: removes a piece that a full disk wrote in part. Errors: kIo, without the file's name.
  [[nodiscard]] Status append(std::span<const std::byte> piece);
  /// Truncates the file to `bytes`.
  void cut(std::uint64_t bytes) noexcept;
  /// Makes the content durable; its name is once the folder is synced, too. Errors: kIo, without the file's name.
  [[nodiscard]] Status sync() const;

 private:
  explicit AppendFile(OwnedFd file) : file_(std::move(file)) {}
  OwnedFd file_;
  std::uint64_t bytes_ = 0;
};

/// Makes the names in `folder` durable. Errors: kIo.
[[nodiscard]] Status sync_folder(const char* folder);
/// Makes everything on the disk of `folder` durable, with one call. Errors: kIo.
[[nodiscard]] Status sync_disk_of(const char* folder);

}  // namespace kinetrace::hal

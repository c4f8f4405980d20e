// A file that grows by whole pieces, and what makes files last through a loss of power.
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
  /// Makes the file. Errors: kIo (it is there already, no permission, disk full).
  [[nodiscard]] static Result<AppendFile> create(const char* path);

  [[nodiscard]] bool valid() const noexcept { return file_.valid(); }
  [[nodiscard]] std::uint64_t bytes() const noexcept { return bytes_; }
  /// All or nothing: what a full disk took of a piece is taken back. Errors: kIo, without the file's name.
  [[nodiscard]] Status append(std::span<const std::byte> piece);
  /// Takes back everything after the first `bytes`.
  void cut(std::uint64_t bytes) noexcept;
  /// The content lasts; so does the name, once its folder is synced too. Errors: kIo, without the file's name.
  [[nodiscard]] Status sync() const;

 private:
  explicit AppendFile(OwnedFd file) : file_(std::move(file)) {}
  OwnedFd file_;
  std::uint64_t bytes_ = 0;
};

/// The names in `folder` last. Errors: kIo.
[[nodiscard]] Status sync_folder(const char* folder);
/// Everything on the disk of `folder` lasts, in one go. Errors: kIo.
[[nodiscard]] Status sync_disk_of(const char* folder);

}  // namespace kinetrace::hal

// Lock of a run folder: one writing run, or any number of readers.
#pragma once

#include <filesystem>

#include "buffered_file.hpp"

namespace kinetrace::recording {

enum class FolderUse { kRead, kWrite };

/// Held for the object's lifetime, at most until the process ends in any way. Locks the folder itself, so no lock file
/// remains.
class FolderLock {
 public:
  /// Does not wait. Without support for locks (some network file systems), the folder counts as free.
  [[nodiscard]] static FolderLock take(const std::filesystem::path& directory, FolderUse use);

  FolderLock() = default;
  /// The folder is in use: by another run, or, for a run, also by readers.
  [[nodiscard]] bool is_refused() const noexcept { return is_refused_; }

 private:
  FileHandle folder_;
  bool is_refused_ = false;
};

}  // namespace kinetrace::recording

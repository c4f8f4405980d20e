// Who uses a run folder: one run that writes, or any number of readers.
#pragma once

#include <filesystem>

#include "buffered_file.hpp"

namespace kinetrace::recording {

enum class FolderUse { kRead, kWrite };

/// Held as long as it lives, and no longer than the process, however that ends. Locks the folder itself, so nothing is
/// left behind in it.
class FolderLock {
 public:
  /// Does not wait. A folder that cannot be locked (some network file systems) counts as free.
  [[nodiscard]] static FolderLock take(const std::filesystem::path& directory, FolderUse use);

  FolderLock() = default;
  /// Somebody else uses the folder: another run, or for a run also its readers.
  [[nodiscard]] bool is_refused() const noexcept { return is_refused_; }

 private:
  FileHandle folder_;
  bool is_refused_ = false;
};

}  // namespace kinetrace::recording

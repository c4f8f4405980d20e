#include "folder_lock.hpp"

#include <cerrno>
#include <sys/file.h>

namespace kinetrace::recording {

FolderLock FolderLock::take(const std::filesystem::path& directory, FolderUse use) {
  FolderLock lock;
  Result<FileHandle> folder = open_file(directory, OpenMode::kFolder);
  if (!folder) {
    return lock;
  }
  const int kind = use == FolderUse::kWrite ? LOCK_EX : LOCK_SH;
  lock.is_refused_ = ::flock(folder->get(), kind | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  lock.folder_ = std::move(*folder);
  return lock;
}

}  // namespace kinetrace::recording

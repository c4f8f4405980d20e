#include "recording/append_file.hpp"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <unistd.h>

#include "util/messages.hpp"

namespace kinetrace::hal {
namespace {

Status sync_opened(const char* folder, int (*sync)(int)) {
  const OwnedFd opened(::open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!opened.valid() || sync(opened.get()) != 0) {
    return fail(ErrorCode::kIo, concat(folder, ": cannot be written: ", std::strerror(errno)));
  }
  return {};
}

}  // namespace

Result<AppendFile> AppendFile::create(const char* path) {
  OwnedFd file(::open(path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644));
  if (!file.valid()) {
    return fail(ErrorCode::kIo, concat(path, ": cannot be made: ", std::strerror(errno)));
  }
  return AppendFile(std::move(file));
}

Status AppendFile::append(std::span<const std::byte> piece) {
  std::size_t done = 0;
  while (done < piece.size()) {
    const ssize_t written =
        pwrite(file_.get(), piece.data() + done, piece.size() - done, static_cast<off_t>(bytes_ + done));
    if (written < 0 && errno == EINTR) {
      continue;
    }
    if (written <= 0) {
      const int reason = written < 0 ? errno : ENOSPC;
      cut(bytes_);
      return fail(ErrorCode::kIo, std::strerror(reason));
    }
    done += static_cast<std::size_t>(written);
  }
  bytes_ += piece.size();
  return {};
}

void AppendFile::cut(std::uint64_t bytes) noexcept {
  // Truncation needs no space. If it fails the disk has gone; readers tolerate the incomplete piece.
  if (ftruncate(file_.get(), static_cast<off_t>(bytes)) == 0) {
    bytes_ = bytes;
  }
}

Status AppendFile::sync() const {
  return fdatasync(file_.get()) == 0 ? Status{} : fail(ErrorCode::kIo, std::strerror(errno));
}

Status sync_folder(const char* folder) {
  return sync_opened(folder, &fsync);
}

Status sync_disk_of(const char* folder) {
  return sync_opened(folder, &syncfs);
}

}  // namespace kinetrace::hal

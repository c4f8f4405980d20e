#include "buffered_file.hpp"

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>

#include "kinetrace/core/input_file.hpp"

namespace kinetrace::recording {
namespace {

/// Writes all of `data` at the file position; returns 0 or the error number.
int write_all(int descriptor, std::span<const std::byte> data) noexcept {
  while (!data.empty()) {
    const ssize_t written = ::write(descriptor, data.data(), data.size());
    if (written >= 0) {
      data = data.subspan(static_cast<std::size_t>(written));
    } else if (errno != EINTR) {
      return errno;
    }
  }
  return 0;
}

/// Does not wait for the other end of a named pipe, but refuses it.
Result<FileHandle> open_regular(const std::filesystem::path& path) {
  const InPlaceResult<InputFile> input = InputFile::open(path.c_str());
  if (!input) {
    return Unexpected(input.error());
  }
  FileHandle file(::fcntl(input->descriptor(), F_DUPFD_CLOEXEC, 0));
  return file.is_open() ? Result<FileHandle>(std::move(file)) : file_error("open", path, errno);
}

}  // namespace

FileHandle::~FileHandle() {
  static_cast<void>(close());
}

int FileHandle::close() noexcept {
  const int descriptor = std::exchange(descriptor_, -1);
  return descriptor >= 0 && ::close(descriptor) != 0 && errno != EINTR ? errno : 0;
}

Unexpected<Error> file_error(std::string_view operation, const std::filesystem::path& path, int error_number) {
  std::string message =
      "cannot " + std::string(operation) + " " + path.string() + ": " + std::generic_category().message(error_number);
  if (error_number == ENOSPC || error_number == EDQUOT || error_number == EFBIG) {
    message += "; free space or record to another folder";
  } else if (error_number == EACCES || error_number == EPERM || error_number == EROFS) {
    message += "; make the folder writable or record to another one";
  }
  return fail(ErrorCode::kIo, std::move(message));
}

Result<FileHandle> open_file(const std::filesystem::path& path, OpenMode mode) {
  if (mode == OpenMode::kRead) {
    return open_regular(path);
  }
  constexpr mode_t kPermissions = 0666;  // Narrowed by the user's umask.
  const int flags = mode == OpenMode::kFolder   ? O_RDONLY | O_DIRECTORY
                    : mode == OpenMode::kCreate ? O_RDWR | O_CREAT | O_TRUNC
                                                : O_RDWR;
  FileHandle file(::open(path.c_str(), flags | O_CLOEXEC, kPermissions));
  if (!file.is_open()) {
    return file_error(mode == OpenMode::kCreate ? "create" : "open", path, errno);
  }
  return file;
}

Result<std::uint64_t> file_size(const FileHandle& file, const std::filesystem::path& path) {
  struct stat info {};
  if (::fstat(file.get(), &info) != 0) {
    return file_error("examine", path, errno);
  }
  return static_cast<std::uint64_t>(info.st_size);
}

Status read_at(const FileHandle& file, std::uint64_t offset, std::span<std::byte> bytes,
               const std::filesystem::path& path) {
  while (!bytes.empty()) {
    const ssize_t count = ::pread(file.get(), bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (count > 0) {
      bytes = bytes.subspan(static_cast<std::size_t>(count));
      offset += static_cast<std::uint64_t>(count);
    } else if (count == 0) {
      return fail(ErrorCode::kIo, "cannot read " + path.string() + ": the file became shorter while it was in use");
    } else if (errno != EINTR) {
      return file_error("read", path, errno);
    }
  }
  return {};
}

Status write_at(const FileHandle& file, std::uint64_t offset, std::span<const std::byte> bytes,
                const std::filesystem::path& path) {
  while (!bytes.empty()) {
    const ssize_t count = ::pwrite(file.get(), bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (count >= 0) {
      bytes = bytes.subspan(static_cast<std::size_t>(count));
      offset += static_cast<std::uint64_t>(count);
    } else if (errno != EINTR) {
      return file_error("write", path, errno);
    }
  }
  return {};
}

Result<BufferedWriter> BufferedWriter::create(std::filesystem::path path, std::span<std::byte> buffer) {
  assert(buffer.size() >= kMinBufferBytes);
  Result<FileHandle> file = open_file(path, OpenMode::kCreate);
  if (!file) {
    return Unexpected(file.error());
  }
  BufferedWriter writer;
  writer.path_ = std::move(path);
  writer.file_ = std::move(*file);
  writer.buffer_ = buffer;
  return writer;
}

BufferedWriter& BufferedWriter::bytes(std::span<const std::byte> data) noexcept {
  while (!data.empty() && file_.is_open()) {
    if (used_ == buffer_.size()) {
      drain();
    }
    const std::size_t count = std::min(data.size(), buffer_.size() - used_);
    std::memcpy(buffer_.data() + used_, data.data(), count);
    used_ += count;
    data = data.subspan(count);
  }
  return *this;
}

void BufferedWriter::drain() noexcept {
  if (error_number_ == 0) {
    error_number_ = write_all(file_.get(), buffer_.first(used_));
  }
  used_ = 0;
}

Status BufferedWriter::status() const {
  return failed() ? Status(file_error("write", path_, error_number_)) : Status{};
}

Status BufferedWriter::flush() {
  if (file_.is_open()) {
    drain();
  }
  return status();
}

Status BufferedWriter::close() {
  if (file_.is_open()) {
    drain();
    const int close_error = file_.close();
    error_number_ = error_number_ != 0 ? error_number_ : close_error;
  }
  return status();
}

}  // namespace kinetrace::recording

#include "kinetrace/core/input_file.hpp"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <initializer_list>
#include <string_view>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>

namespace kinetrace {
namespace {

Unexpected<InPlaceError> file_error(ErrorCode code, std::string_view path,
                                    std::initializer_list<std::string_view> what) {
  return Unexpected(InPlaceError(code, path, what));
}

const char* kind_of(mode_t mode) {
  switch (mode & S_IFMT) {
    case S_IFDIR: return "a folder";
    case S_IFIFO: return "a named pipe";
    case S_IFSOCK: return "a socket";
    default: return "a device";
  }
}

}  // namespace

InPlaceResult<InputFile> InputFile::open(const char* path) {
  // Without O_NONBLOCK, opening a named pipe waits for a writer. It has no effect on regular files.
  const int descriptor = ::open(path, O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  const int reason = errno;
  if (descriptor < 0 && (reason == ENOENT || reason == ENOTDIR)) {
    return file_error(ErrorCode::kNotFound, path, {"no such file; check the path"});
  }
  if (descriptor < 0 && reason == ENXIO) {
    return file_error(ErrorCode::kBadFormat, path, {"is a socket or a device, not a file; give the path of a file"});
  }
  if (descriptor < 0) {
    return file_error(
        ErrorCode::kIo, path,
        {"cannot be opened (", std::strerror(reason), reason == EACCES ? "); check its permissions" : ")"});
  }
  InputFile file(descriptor, 0);
  struct stat status {};
  if (::fstat(descriptor, &status) != 0) {
    return file_error(ErrorCode::kIo, path, {"cannot be read (", std::strerror(errno), ")"});
  }
  if (!S_ISREG(status.st_mode)) {
    return file_error(ErrorCode::kBadFormat, path,
                      {"is ", kind_of(status.st_mode), ", not a file; give the path of a file"});
  }
  file.size_bytes_ = static_cast<std::size_t>(status.st_size);
  return file;
}

InputFile::InputFile(InputFile&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)), size_bytes_(other.size_bytes_) {}

InputFile::~InputFile() {
  if (descriptor_ >= 0) {
    ::close(descriptor_);
  }
}

std::size_t InputFile::read(std::size_t offset, std::span<std::uint8_t> target) const noexcept {
  std::size_t done = 0;
  while (done < target.size()) {
    const ssize_t got =
        ::pread(descriptor_, target.data() + done, target.size() - done, static_cast<off_t>(offset + done));
    if (got < 0 && errno == EINTR) {
      continue;
    }
    if (got <= 0) {
      break;
    }
    done += static_cast<std::size_t>(got);
  }
  return done;
}

Result<std::string> InputFile::read_whole(const std::filesystem::path& path, std::size_t max_bytes) {
  const InPlaceResult<InputFile> file = open(path.c_str());
  if (!file) {
    return Unexpected(file.error());
  }
  if (file->size_bytes() > max_bytes) {
    return file_error(ErrorCode::kBadFormat, path.c_str(),
                      {"has ", NumberText(file->size_bytes()), " bytes; at most ", NumberText(max_bytes),
                       " are read of a file of this kind, is it the right one?"});
  }
  std::string content(file->size_bytes(), '\0');
  if (file->read(0, {reinterpret_cast<std::uint8_t*>(content.data()), content.size()}) != content.size()) {
    return file_error(ErrorCode::kIo, path.c_str(), {"cannot be read to its end; check the storage device"});
  }
  return content;
}

}  // namespace kinetrace

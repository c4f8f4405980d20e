#include "file_bytes.hpp"

#include <cerrno>
#include <fcntl.h>
#include <string>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>
#include <utility>

namespace kinetrace::imaging {

Unexpected<Error> file_error(ErrorCode code, const char* path, std::string_view what) {
  return fail(code, std::string(path).append(": ").append(what));
}

Result<InputFile> InputFile::open(const char* path) {
  const int descriptor = ::open(path, O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) {
    const int reason = errno;
    if (reason == ENOENT || reason == ENOTDIR) {
      return file_error(ErrorCode::kNotFound, path, "no such file; check the path");
    }
    return file_error(ErrorCode::kIo, path, "cannot be opened (" + std::generic_category().message(reason) + ")");
  }
  InputFile file(descriptor, 0);
  struct stat status {};
  if (::fstat(descriptor, &status) != 0 || !S_ISREG(status.st_mode)) {
    return file_error(ErrorCode::kBadFormat, path, "is not a regular file; give the path of an image");
  }
  if (status.st_size == 0) {
    return file_error(ErrorCode::kBadFormat, path, "is empty (0 bytes); copy it again or remove it");
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

}  // namespace kinetrace::imaging

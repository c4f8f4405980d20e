#include "capture/v4l2/v4l2_file.hpp"

#include <cerrno>
#include <fcntl.h>
#include <linux/videodev2.h>
#include <sys/ioctl.h>
#include <system_error>

#include "util/messages.hpp"

namespace kinetrace::hal {
namespace {

int machine_ioctl(int fd, unsigned long request, void* argument) {
  return ::ioctl(fd, request, argument);
}

std::string reason(int code) {
  return std::generic_category().message(code);
}

}  // namespace

Result<V4l2File> V4l2File::open(const std::string& path) {
  int fd = -1;
  do {
    fd = ::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  } while (fd < 0 && errno == EINTR);
  if (fd >= 0) {
    return V4l2File(path, OwnedFd(fd), &machine_ioctl);
  }
  switch (errno) {
    case ENOENT:
    case ENODEV:
    case ENXIO: return fail(ErrorCode::kNotFound, path + ": there is no such device");
    case EACCES:
    case EPERM: return fail(ErrorCode::kIo, path + ": permission denied; add your user to the group 'video'");
    default: return Unexpected(V4l2File(path, OwnedFd(), &machine_ioctl).error(errno, "open"));
  }
}

int V4l2File::call(unsigned long request, void* argument) const noexcept {
  while (ioctl_(fd_.get(), request, argument) != 0) {
    if (errno != EINTR) {
      return errno;
    }
  }
  return 0;
}

Status V4l2File::require(unsigned long request, void* argument, const char* what) const {
  if (const int code = call(request, argument); code != 0) {
    return Unexpected(error(code, what));
  }
  return {};
}

Error V4l2File::error(int code, const char* what) const {
  if (code == ENODEV || gone()) {
    return {ErrorCode::kDisconnected, path_ + ": the device has gone; check its cable and power"};
  }
  if (code == EBUSY) {
    return {ErrorCode::kIo, concat(path_, ": is in use by another program (", what, "); close that one, `fuser -v ",
                                   path_, "` names it")};
  }
  return {ErrorCode::kIo, concat(path_, ": ", what, ": ", reason(code))};
}

bool V4l2File::gone() const noexcept {
  v4l2_capability capability{};
  return fd_.valid() && call(VIDIOC_QUERYCAP, &capability) == ENODEV;
}

}  // namespace kinetrace::hal

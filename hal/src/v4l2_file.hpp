// An open V4L2 device file.
#pragma once

#include <string>
#include <utility>

#include "kinetrace/core/result.hpp"
#include "owned_fd.hpp"

namespace kinetrace::hal {

class V4l2File {
 public:
  V4l2File() = default;
  /// Errors: kNotFound, kIo (busy, no permission); the message names the remedy.
  [[nodiscard]] static Result<V4l2File> open(const std::string& path);

  /// ioctl(2), again where a signal interrupted it: 0, or the errno.
  [[nodiscard]] int call(unsigned long request, void* argument) const noexcept;
  /// The same as a Status: kDisconnected for a device that has gone, kIo for everything else, "PATH: WHAT: reason".
  [[nodiscard]] Status require(unsigned long request, void* argument, const char* what) const;
  [[nodiscard]] Error error(int code, const char* what) const;
  /// The driver no longer answers for this file: the device was unplugged.
  [[nodiscard]] bool gone() const noexcept;

  [[nodiscard]] int fd() const noexcept { return fd_.get(); }
  [[nodiscard]] const std::string& path() const noexcept { return path_; }

 private:
  V4l2File(std::string path, OwnedFd fd) : path_(std::move(path)), fd_(std::move(fd)) {}

  std::string path_;
  OwnedFd fd_;
};

}  // namespace kinetrace::hal

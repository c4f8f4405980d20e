// An open V4L2 device file.
#pragma once

#include <string>
#include <utility>

#include "kinetrace/core/result.hpp"
#include "util/owned_fd.hpp"

namespace kinetrace::hal {

class V4l2File {
 public:
  /// ioctl(2): 0, or -1 and errno.
  using Ioctl = int (*)(int fd, unsigned long request, void* argument);

  V4l2File() = default;
  /// For an open device; tests pass a scripted driver.
  V4l2File(std::string path, OwnedFd fd, Ioctl ioctl) : path_(std::move(path)), fd_(std::move(fd)), ioctl_(ioctl) {}
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
  std::string path_;
  OwnedFd fd_;
  Ioctl ioctl_ = nullptr;  ///< Not called before a device is open.
};

}  // namespace kinetrace::hal

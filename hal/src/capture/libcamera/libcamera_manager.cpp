#include "capture/libcamera/libcamera_manager.hpp"

#include <system_error>

#include "util/messages.hpp"

namespace kinetrace::hal {
namespace {

class RunningManager {
 public:
  RunningManager() : code_(manager_.start()) {}
  RunningManager(const RunningManager&) = delete;
  RunningManager& operator=(const RunningManager&) = delete;
  ~RunningManager() {
    if (code_ == 0) {
      manager_.stop();
    }
  }
  [[nodiscard]] int code() const { return code_; }
  [[nodiscard]] libcamera::CameraManager& get() { return manager_; }

 private:
  libcamera::CameraManager manager_;
  int code_;
};

}  // namespace

Result<libcamera::CameraManager*> libcamera_manager() {
  static RunningManager manager;
  if (manager.code() != 0) {
    return fail(ErrorCode::kIo, concat("libcamera does not start: ", std::generic_category().message(-manager.code())));
  }
  return &manager.get();
}

Result<std::shared_ptr<libcamera::Camera>> find_libcamera(const std::string& id) {
  const auto manager = libcamera_manager();
  if (!manager) {
    return Unexpected(manager.error());
  }
  std::vector<std::string> ids;
  for (std::shared_ptr<libcamera::Camera>& camera : (*manager)->cameras()) {
    if (camera->id() == id) {
      return std::move(camera);
    }
    ids.push_back(camera->id());
  }
  return fail(ErrorCode::kNotFound, concat(id, ": libcamera knows no camera of this id; ",
                                           ids.empty() ? "it knows none at all" : "there are: " + listed(ids)));
}

std::string libcamera_name(const libcamera::Camera& camera) {
  const auto model = camera.properties().get(libcamera::properties::Model);
  return model ? std::string(*model) : camera.id();
}

libcamera::PixelFormat libcamera_format(PixelFormat format) {
  switch (format) {
    case PixelFormat::kGrey8: return libcamera::PixelFormat::fromString("R8");
    case PixelFormat::kGrey10: return libcamera::PixelFormat::fromString("R10");
    case PixelFormat::kGrey16: return libcamera::PixelFormat::fromString("R16");
    case PixelFormat::kYuyv: return libcamera::PixelFormat::fromString("YUYV");
    case PixelFormat::kNv12: return libcamera::PixelFormat::fromString("NV12");
    case PixelFormat::kMjpeg: return libcamera::PixelFormat::fromString("MJPEG");
  }
  return {};
}

}  // namespace kinetrace::hal

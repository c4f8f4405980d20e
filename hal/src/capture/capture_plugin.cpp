#include "capture/capture_plugin.hpp"

#include <dlfcn.h>

#include "kinetrace/hal/libcamera_backend.hpp"
#include "util/messages.hpp"

namespace kinetrace::hal {
namespace {

Unexpected<Error> unloadable(const std::string& path) {
  const char* reason = dlerror();
  return fail(ErrorCode::kUnsupported, concat("cannot load ", path, ": ", reason == nullptr ? "no reason" : reason,
                                              "; install libcamera in the release that it was built for"));
}

}  // namespace

Status load_libcamera_plugin(const std::string& path) {
  void* library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) {
    return unloadable(path);
  }
  const auto plugin = reinterpret_cast<CapturePlugin>(dlsym(library, kCapturePluginSymbol));
  if (plugin == nullptr) {
    return unloadable(path);
  }
  plugin(&register_capture_backend);
  return {};
}

}  // namespace kinetrace::hal

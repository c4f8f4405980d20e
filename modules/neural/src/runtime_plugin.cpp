#include <dlfcn.h>
#include <string>

#include "runtime.hpp"

namespace kinetrace::neural {
namespace {

Unexpected<Error> unloadable(const std::string& plugin) {
  const char* reason = dlerror();
  return fail(ErrorCode::kUnsupported,
              "segmentation.onnx: cannot load " + plugin + ": " + (reason == nullptr ? "no reason" : reason) +
                  "; install OpenCV's dnn library (Debian: libopencv-dnn406) beside Kinetrace");
}

}  // namespace

Result<MakeRuntime> load_runtime(const std::string& plugin) {
  void* library = dlopen(plugin.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) {
    return unloadable(plugin);
  }
  const auto entry = reinterpret_cast<RuntimePlugin>(dlsym(library, kRuntimePluginSymbol));
  return entry == nullptr ? Result<MakeRuntime>(unloadable(plugin)) : entry();
}

}  // namespace kinetrace::neural

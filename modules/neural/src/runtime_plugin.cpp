#include <dlfcn.h>
#include <filesystem>
#include <link.h>
#include <string>
#include <system_error>

#include "runtime.hpp"

namespace kinetrace::neural {
namespace {

namespace fs = std::filesystem;

constexpr const char* kDefaultPlugin = "kinetrace-opencv-dnn.so";

// Folder of the shared library or, if linked statically, of the program.
fs::path own_folder() {
  Dl_info info{};
  void* map = nullptr;
  if (dladdr1(reinterpret_cast<const void*>(&load_runtime), &info, &map, RTLD_DL_LINKMAP) != 0) {
    // The program itself has an empty name.
    if (const fs::path library = static_cast<const link_map*>(map)->l_name; !library.empty()) {
      return library.parent_path();
    }
  }
  std::error_code error;
  return fs::read_symlink("/proc/self/exe", error).parent_path();
}

std::string default_plugin() {
  const fs::path folder = own_folder();
  // Beside the program in a build; below lib for bin/PROGRAM, lib/LIBRARY and lib/ARCHITECTURE/LIBRARY in an
  // installation.
  for (const char* place : {".", "../lib/kinetrace", "kinetrace", "../kinetrace"}) {
    const fs::path plugin = folder / place / kDefaultPlugin;
    std::error_code error;
    if (fs::exists(plugin, error)) {
      return plugin.string();
    }
  }
  return kDefaultPlugin;
}

Unexpected<Error> unloadable(const std::string& plugin) {
  const char* reason = dlerror();
  return fail(ErrorCode::kUnsupported,
              "segmentation.onnx: cannot load " + plugin + ": " + (reason == nullptr ? "no reason" : reason) +
                  "; install the package kinetrace-networks, or OpenCV's dnn library beside a Kinetrace of your own");
}

}  // namespace

Result<MakeRuntime> load_runtime(const std::string& named) {
  const std::string plugin = named.empty() ? default_plugin() : named;
  void* library = dlopen(plugin.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) {
    return unloadable(plugin);
  }
  const auto entry = reinterpret_cast<RuntimePlugin>(dlsym(library, kRuntimePluginSymbol));
  return entry == nullptr ? Result<MakeRuntime>(unloadable(plugin)) : entry();
}

}  // namespace kinetrace::neural

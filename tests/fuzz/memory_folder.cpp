#include "memory_folder.hpp"

#include <cstddef>
#include <fcntl.h>
#include <system_error>
#include <unistd.h>

#include "fuzz_target.hpp"

namespace kinetrace::fuzz {

MemoryFolder::MemoryFolder() {
  static int count = 0;
  path_ = std::filesystem::temp_directory_path() /
          ("kinetrace_fuzz_" + std::to_string(::getpid()) + "_" + std::to_string(count++));
  std::filesystem::create_directories(path_);
}

MemoryFolder::~MemoryFolder() {
  for (const auto& [name, file] : files_) {
    ::close(file.descriptor);
  }
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

const std::string& MemoryFolder::put(const std::string& name, std::string_view content) {
  File& file = files_[name];
  if (file.path.empty()) {
    const std::filesystem::path full = path_ / name;
    std::filesystem::create_directories(full.parent_path());
    file.path = full.string();
    file.descriptor = ::open(file.path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  }
  const auto size = static_cast<off_t>(content.size());
  require(::ftruncate(file.descriptor, size) == 0 &&
          ::pwrite(file.descriptor, content.data(), content.size(), 0) == static_cast<ssize_t>(size));
  return file.path;
}

void MemoryFolder::put_parts(const std::vector<std::string>& names, std::string_view input) {
  const std::vector<std::string_view> parts = parts_of(input, names.size());
  for (std::size_t i = 0; i < names.size(); ++i) {
    put(names[i], parts[i]);
  }
}

}  // namespace kinetrace::fuzz

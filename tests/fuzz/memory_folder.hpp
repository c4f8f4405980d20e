// Files for parsers that take paths.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace kinetrace::fuzz {

/// A folder below the system's folder for temporary files, which tests/fuzz/run puts into memory. Files stay open, so
/// that new content costs two system calls.
class MemoryFolder {
 public:
  MemoryFolder();
  MemoryFolder(const MemoryFolder&) = delete;
  MemoryFolder& operator=(const MemoryFolder&) = delete;
  MemoryFolder(MemoryFolder&&) = delete;
  MemoryFolder& operator=(MemoryFolder&&) = delete;
  ~MemoryFolder();

  [[nodiscard]] const std::filesystem::path& path() const noexcept { return path_; }
  /// Gives a file this content; creates it and its parent folders if needed. Returns its path.
  const std::string& put(const std::string& name, std::string_view content);
  /// Writes each part of an input to one of the files.
  void put_parts(const std::vector<std::string>& names, std::string_view input);

 private:
  struct File {
    std::string path;
    int descriptor = -1;
  };
  std::filesystem::path path_;
  std::map<std::string, File> files_;
};

}  // namespace kinetrace::fuzz

#include "image_file.hpp"

#include <string>

namespace kinetrace::imaging {

Unexpected<Error> file_error(ErrorCode code, const char* path, std::string_view what) {
  return fail(code, std::string(path).append(": ").append(what));
}

Result<InputFile> open_image(const char* path) {
  Result<InputFile> file = InputFile::open(path);
  if (file && file->size_bytes() == 0) {
    return file_error(ErrorCode::kBadFormat, path, "is empty (0 bytes); copy it again or remove it");
  }
  return file;
}

}  // namespace kinetrace::imaging

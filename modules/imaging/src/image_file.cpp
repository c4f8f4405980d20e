#include "image_file.hpp"

namespace kinetrace::imaging {

Unexpected<InPlaceError> file_error(ErrorCode code, const char* path, std::initializer_list<std::string_view> what) {
  return Unexpected(InPlaceError(code, path, what));
}

Unexpected<InPlaceError> size_error(const char* path, int width, int height, int expected_width, int expected_height,
                                    std::string_view remedy) {
  return file_error(ErrorCode::kInvalidArgument, path,
                    {"is ", NumberText(width), "x", NumberText(height), " pixels, expected ",
                     NumberText(expected_width), "x", NumberText(expected_height), remedy});
}

InPlaceResult<InputFile> open_image(const char* path) {
  InPlaceResult<InputFile> file = InputFile::open(path);
  if (file && file->size_bytes() == 0) {
    return file_error(ErrorCode::kBadFormat, path, {"is empty (0 bytes); copy it again or remove it"});
  }
  return file;
}

}  // namespace kinetrace::imaging

// Image files as bytes.
#pragma once

#include <string_view>

#include "kinetrace/core/input_file.hpp"
#include "kinetrace/core/result.hpp"

namespace kinetrace::imaging {

/// "PATH: WHAT", as every error about a file begins.
[[nodiscard]] Unexpected<Error> file_error(ErrorCode code, const char* path, std::string_view what);

/// As InputFile::open; also kBadFormat if the file is empty.
[[nodiscard]] Result<InputFile> open_image(const char* path);

}  // namespace kinetrace::imaging

// Image files as bytes.
#pragma once

#include <algorithm>
#include <cstdint>
#include <initializer_list>
#include <string_view>

#include "kinetrace/core/in_place_error.hpp"
#include "kinetrace/core/input_file.hpp"

namespace kinetrace::imaging {

/// Error with the message "PATH: WHAT".
[[nodiscard]] Unexpected<InPlaceError> file_error(ErrorCode code, const char* path,
                                                  std::initializer_list<std::string_view> what);

/// kInvalidArgument: an image of another size than was expected.
[[nodiscard]] Unexpected<InPlaceError> size_error(const char* path, int width, int height, int expected_width,
                                                  int expected_height, std::string_view remedy);

/// As InputFile::open; also kBadFormat if the file is empty.
[[nodiscard]] InPlaceResult<InputFile> open_image(const char* path);

/// The upper eight of a sample's `sample_bits` bits; white for larger values.
[[nodiscard]] inline std::uint8_t upper_bits(std::uint32_t sample, int sample_bits) {
  constexpr std::uint32_t kWhite = 255;
  return static_cast<std::uint8_t>(std::min(sample >> static_cast<unsigned>(sample_bits - 8), kWhite));
}

}  // namespace kinetrace::imaging

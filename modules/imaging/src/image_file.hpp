// Image files as bytes.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string_view>

#include "kinetrace/core/input_file.hpp"
#include "kinetrace/core/result.hpp"

namespace kinetrace::imaging {

/// "PATH: WHAT", as every error about a file begins.
[[nodiscard]] Unexpected<Error> file_error(ErrorCode code, const char* path, std::string_view what);

/// As InputFile::open; also kBadFormat if the file is empty.
[[nodiscard]] Result<InputFile> open_image(const char* path);

/// The upper eight of a sample's `sample_bits` bits; white beyond.
[[nodiscard]] inline std::uint8_t upper_bits(std::uint32_t sample, int sample_bits) {
  constexpr std::uint32_t kWhite = 255;
  return static_cast<std::uint8_t>(std::min(sample >> static_cast<unsigned>(sample_bits - 8), kWhite));
}

}  // namespace kinetrace::imaging

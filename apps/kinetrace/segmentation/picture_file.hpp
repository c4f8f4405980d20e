// Pictures from files, grey or in colour.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/image_view.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/imaging/image_reader.hpp"
#include "kinetrace/neural/picture.hpp"

namespace kinetrace::app {

/// Reads pictures in sequence; the first determines the memory.
class PictureFiles {
 public:
  static constexpr int kMaxSide_px = 8192;

  struct Loaded {
    neural::Picture picture;  ///< As it is: grey or colour.
    GrayView gray;
  };
  /// The result is valid until the next call. Errors, naming the file: those of imaging::ImageReader.
  [[nodiscard]] Result<Loaded> read(const std::filesystem::path& path);

 private:
  std::optional<Arena> arena_;
  std::optional<imaging::ImageReader> reader_;
  std::vector<std::uint8_t> gray_;
  std::vector<imaging::Rgb8> colours_;
};

/// The given files, and image files (by extension) of given folders, sorted by name. Errors: kNotFound.
[[nodiscard]] Result<std::vector<std::filesystem::path>> picture_files(const std::vector<std::filesystem::path>& paths);

}  // namespace kinetrace::app

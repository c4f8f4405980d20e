// The images in a folder.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "kinetrace/core/result.hpp"
#include "kinetrace/hal/frame_list.hpp"

namespace kinetrace::hal {

struct ImageFolder {
  FrameFolder files;
  std::vector<std::string> stems;  ///< In order of their number, then of their name.
  std::size_t max_file_bytes = 0;
};

/// Images whose name begins with `prefix` and, before the extension, ends with `tag`: the stem is what stands before
/// the tag. Errors: kNotFound (no folder, no image), kUnsupported (several kinds of image in one folder).
[[nodiscard]] Result<ImageFolder> list_images(const std::filesystem::path& folder, std::string_view prefix = "",
                                              std::string_view tag = "");

/// Path of the image with this stem.
[[nodiscard]] std::string image_path(const FrameFolder& folder, std::string_view stem);

/// Number that a stem ends with: "frame_000012" is 12; none without digits at the end or beyond 64 bits.
[[nodiscard]] std::optional<std::int64_t> trailing_number(std::string_view stem);

/// Subfolders by name, sorted; empty if the folder does not exist.
[[nodiscard]] std::vector<std::string> subfolders(const std::filesystem::path& folder);

[[nodiscard]] bool is_folder(const std::filesystem::path& path);
[[nodiscard]] bool is_file(const std::filesystem::path& path);
/// Whether the path exists, of any kind: an unreadable one is to be reported, not skipped.
[[nodiscard]] bool is_there(const std::filesystem::path& path);

}  // namespace kinetrace::hal

#include "figure/picture_place.hpp"

#include <string>
#include <system_error>

#include "kinetrace/imaging/image_info.hpp"

namespace kinetrace::figure {

namespace fs = std::filesystem;

Status check_replaceable(const fs::path& file) {
  std::error_code error;
  if (!fs::is_regular_file(file, error) || fs::file_size(file, error) == 0) {
    return {};
  }
  const Result<imaging::ImageInfo> info = imaging::read_image_info(file.c_str());
  if (info && info->format == imaging::ImageFormat::kPng && info->channels == 3 && info->bit_depth == 8) {
    return {};
  }
  return fail(ErrorCode::kInvalidArgument,
              file.string() + ": is there already, and is no picture of an earlier figure; name another place");
}

Status check_apart(const fs::path& directory, const hal::FrameList& recording) {
  for (const std::string& folder : {recording.left().folder, recording.right().folder}) {
    std::error_code error;
    if (!folder.empty() && fs::equivalent(directory, folder, error)) {
      return fail(
          ErrorCode::kInvalidArgument,
          directory.string() + ": holds the recording's images, which pictures would replace; name another folder");
    }
  }
  return {};
}

}  // namespace kinetrace::figure

#include "figure/picture_place.hpp"

#include <string>
#include <system_error>

#include "kinetrace/core/files.hpp"
#include "kinetrace/imaging/image_info.hpp"

namespace kinetrace::figure {

namespace fs = std::filesystem;

Status check_replaceable(const fs::path& file) {
  return check_same_kind(file, {"picture of an earlier figure", &imaging::is_drawn_picture});
}

Status check_apart(const fs::path& directory, const hal::FrameList& recording) {
  for (const std::string& folder : {recording.left().folder, recording.right().folder}) {
    // KITTI's image_00 holds `data`.
    std::error_code error;
    if (!folder.empty() &&
        (is_inside(directory, folder) || fs::equivalent(directory, fs::path(folder) / "..", error))) {
      return fail(ErrorCode::kOccupied,
                  directory.string() + ": lies among the recording's images; name another folder");
    }
  }
  return {};
}

}  // namespace kinetrace::figure

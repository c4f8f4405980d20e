#include "budget_recording.hpp"

#include <cstdlib>

namespace kinetrace::test {

std::optional<BudgetRecording> street_clip() {
  const char* named = std::getenv("KINETRACE_DATA");
  const std::filesystem::path data = named != nullptr ? named : KINETRACE_DEFAULT_DATA;
  const std::filesystem::path drive = data / "kitti_raw/2011_09_26/2011_09_26_drive_0039_extract";
  const std::filesystem::path masks = data / "masks/kitti_raw_0039";
  if (!std::filesystem::is_directory(drive / "image_00/data") || !std::filesystem::is_directory(masks)) {
    return std::nullopt;
  }
  const auto images = std::filesystem::directory_iterator(drive / "image_00/data");
  return BudgetRecording{"kitti-raw:" + drive.string(),
                         "masks:" + (masks / "detections_left").string() + "," + (masks / "detections_right").string(),
                         static_cast<int>(std::distance(begin(images), end(images)))};
}

BudgetRecording rendered_clip(const std::filesystem::path& folder) {
  constexpr int kRenderedFrames = 20;
  return write_rendered_clip(folder, kRenderedFrames);
}

bool is_long() {
  return std::getenv("KINETRACE_LONG_TESTS") != nullptr;
}

int passes() {
  constexpr int kQuick = 6;
  constexpr int kLong = 50;
  return is_long() ? kLong : kQuick;
}

}  // namespace kinetrace::test

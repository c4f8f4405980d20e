// A rendered drive as a recording on disk.
#pragma once

#include <filesystem>
#include <string>

namespace kinetrace::test {

/// What `kinetrace run` is told.
struct RenderedClip {
  std::string dataset;       ///< LAYOUT:PATH
  std::string segmentation;  ///< masks:LEFT,RIGHT
  int frames = 0;
};

/// A StreetDrive with one vehicle, in KITTI odometry layout, with masks of both eyes.
[[nodiscard]] RenderedClip write_rendered_clip(const std::filesystem::path& folder, int frames);

}  // namespace kinetrace::test

// A rendered drive as a recording on disk.
#pragma once

#include <filesystem>
#include <string>

#include "street_drive.hpp"

namespace kinetrace::test {

/// Arguments of `kinetrace run` for this recording.
struct RenderedClip {
  std::string dataset;       ///< LAYOUT:PATH
  std::string segmentation;  ///< masks:LEFT,RIGHT
  int frames = 0;
};

/// A drive in KITTI odometry layout, with masks of both views.
[[nodiscard]] RenderedClip write_rendered_clip(const std::filesystem::path& folder, const StreetDrive& street,
                                               int frames);
/// With one vehicle.
[[nodiscard]] RenderedClip write_rendered_clip(const std::filesystem::path& folder, int frames);

}  // namespace kinetrace::test

// Reads mask files as run lengths, by frame number.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <vector>

#include "kinetrace/core/image_view.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/publishing/mask_exchange.hpp"

namespace kinetrace::app {

/// Assignment of files to frames.
enum class MaskNaming : std::uint8_t {
  kNumber,  ///< The file's name is the frame's number, as in KITTI.
  kOrder,   ///< The first file, by name, is frame 0.
};

/// The .png files of a folder by frame number. Errors: kNotFound (no folder, no such file), kBadFormat (a name that is
/// no number).
[[nodiscard]] Result<std::map<std::int64_t, std::filesystem::path>> find_mask_files(const std::filesystem::path& folder,
                                                                                    MaskNaming naming);

/// The masks of a KITTI MOTS image (16 bit) or one of instance numbers (8 bit): one mask per value, in ascending order;
/// 10000, and 255 in 8 bits, become kIgnoreClass, as in a run that reads the files itself.
[[nodiscard]] std::vector<publishing::MaskSender::Image::Mask> masks_of(ImageView<const std::uint16_t> image,
                                                                        int bit_depth);

}  // namespace kinetrace::app

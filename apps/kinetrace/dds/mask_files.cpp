#include "dds/mask_files.hpp"

#include <algorithm>
#include <charconv>
#include <limits>
#include <string>
#include <system_error>

#include "kinetrace/core/files.hpp"
#include "kinetrace/core/instance_masks.hpp"

namespace kinetrace::app {
namespace {

namespace fs = std::filesystem;
using Mask = publishing::MaskSender::Image::Mask;

constexpr std::uint16_t kMotsClassStep = 1000;
constexpr std::uint16_t kInstanceIgnore = 255;

Result<std::vector<fs::path>> png_files(const fs::path& folder) {
  if (const Status there = check_folder(folder, "no such folder; name the one of the masks"); !there) {
    return Unexpected(there.error());
  }
  std::vector<fs::path> files;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    if (entry.path().extension() == ".png") {
      files.push_back(entry.path());
    }
  }
  if (files.empty()) {
    return fail(ErrorCode::kNotFound, folder.string() + " holds no .png files; name the folder of KITTI MOTS masks");
  }
  std::sort(files.begin(), files.end());
  return files;
}

/// Appends a run; one too long for 16 bits is split by a run of length 0.
void push_run(std::size_t length, std::vector<std::uint16_t>& runs) {
  constexpr std::size_t kMax = std::numeric_limits<std::uint16_t>::max();
  for (; length > kMax; length -= kMax) {
    runs.push_back(kMax);
    runs.push_back(0);
  }
  runs.push_back(static_cast<std::uint16_t>(length));
}

std::vector<std::uint16_t> runs_of(ImageView<const std::uint16_t> image, std::uint16_t value, const PixelBox& box) {
  std::vector<std::uint16_t> runs;
  std::size_t length = 0;
  bool inside = false;
  for (int y = box.y0; y < box.y1; ++y) {
    for (int x = box.x0; x < box.x1; ++x) {
      if ((image.at(x, y) == value) != inside) {
        push_run(length, runs);
        length = 0;
        inside = !inside;
      }
      ++length;
    }
  }
  push_run(length, runs);
  return runs;
}

std::uint16_t class_of(std::uint16_t value, int bit_depth) {
  if (bit_depth == 8) {
    return value == kInstanceIgnore ? kIgnoreClass : kUnknownClass;
  }
  return static_cast<std::uint16_t>(value / kMotsClassStep);  // 10000 is class 10, "ignore".
}

}  // namespace

Result<std::map<std::int64_t, fs::path>> find_mask_files(const fs::path& folder, MaskNaming naming) {
  const Result<std::vector<fs::path>> files = png_files(folder);
  if (!files) {
    return Unexpected(files.error());
  }
  std::map<std::int64_t, fs::path> by_frame;
  for (const fs::path& file : *files) {
    auto frame = static_cast<std::int64_t>(by_frame.size());
    if (naming == MaskNaming::kNumber) {
      const std::string stem = file.stem().string();
      const auto [end, error] = std::from_chars(stem.data(), stem.data() + stem.size(), frame);
      if (error != std::errc() || end != stem.data() + stem.size()) {
        return fail(ErrorCode::kBadFormat, file.string() + " is not named by a frame number; use --by-order");
      }
    }
    by_frame[frame] = file;
  }
  return by_frame;
}

std::vector<Mask> masks_of(ImageView<const std::uint16_t> image, int bit_depth) {
  std::map<std::uint16_t, PixelBox> boxes;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      if (const std::uint16_t value = image.at(x, y); value != 0) {
        boxes[value].include(x, y);
      }
    }
  }
  std::vector<Mask> masks;
  masks.reserve(boxes.size());
  for (const auto& [value, box] : boxes) {
    masks.push_back({class_of(value, bit_depth), 1.F, box, runs_of(image, value, box)});
  }
  return masks;
}

}  // namespace kinetrace::app

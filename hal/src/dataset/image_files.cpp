#include "dataset/image_files.hpp"

#include <algorithm>

#include "kinetrace/core/arena.hpp"
#include "util/image_folder.hpp"
#include "util/messages.hpp"

namespace kinetrace::hal {
namespace {

constexpr int kFullBits = 16;

// By the first readable header: all images of a recording have one format.
bool has_grey_of_16_bits(const FrameList& frames) {
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const std::string_view stem = frames[i].left_stem;
    const auto info = imaging::read_image_info(image_path(frames.left(), stem).c_str());
    if (!stem.empty() && info) {
      return info->bit_depth == kFullBits && info->channels <= 2;
    }
  }
  return false;
}

// From images spread over the recording. Unreadable ones are skipped here, and counted when the recording is played.
int most_used_bits(const FrameList& frames, imaging::ImageReader& reader) {
  constexpr std::size_t kFramesLookedAt = 8;
  const std::size_t step = std::max<std::size_t>(1, frames.size() / kFramesLookedAt);
  int most = 0;
  for (std::size_t i = 0; most < kFullBits && i < frames.size(); i += step) {
    if (frames[i].complete()) {
      most = std::max({most, reader.used_bits(image_path(frames.left(), frames[i].left_stem).c_str()).value_or(0),
                       reader.used_bits(image_path(frames.right(), frames[i].right_stem).c_str()).value_or(0)});
    }
  }
  return most;
}

}  // namespace

// A file much larger than its pixels is damaged: it is skipped, so that it does not determine the size of the buffers.
imaging::ImageReaderConfig image_reader_config(const Dataset& dataset) {
  constexpr std::size_t kMinBuffer = 4096;
  constexpr std::size_t kBytesPerPixel = 8;  // 16-bit colour with alpha, not compressed.
  constexpr std::size_t kHeaders = std::size_t{1} << 20;
  const int width = dataset.calibration.raw_width_px();
  const int height = dataset.calibration.raw_height_px();
  const std::size_t sensible =
      kBytesPerPixel * static_cast<std::size_t>(width) * static_cast<std::size_t>(height) + kHeaders;
  return {.max_width_px = width,
          .max_height_px = height,
          .max_file_bytes = std::clamp(dataset.max_file_bytes, kMinBuffer, sensible)};
}

void find_sample_bits(Dataset& dataset) {
  if (!has_grey_of_16_bits(dataset.frames)) {
    return;
  }
  const imaging::ImageReaderConfig config = image_reader_config(dataset);
  Arena arena(imaging::ImageReader::required_bytes(config));
  Result<imaging::ImageReader> reader = imaging::ImageReader::create(config, arena);
  const int used_bits = reader ? most_used_bits(dataset.frames, *reader) : 0;
  if (used_bits == 0 || imaging::sample_bits_for(used_bits) == kFullBits) {
    return;
  }
  dataset.sample_bits = imaging::sample_bits_for(used_bits);
  dataset.notes.push_back(concat(dataset.frames.left().folder, ": the images hold values of ",
                                 std::to_string(dataset.sample_bits),
                                 " bits in 16; they are taken for those of a camera of so many bits"));
}

}  // namespace kinetrace::hal

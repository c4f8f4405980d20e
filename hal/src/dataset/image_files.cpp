#include "dataset/image_files.hpp"

#include <algorithm>
#include <cstdlib>
#include <optional>
#include <string>

#include "kinetrace/core/arena.hpp"
#include "util/image_folder.hpp"
#include "util/messages.hpp"

namespace kinetrace::hal {
namespace {

constexpr int kFullBits = 16;

struct View {
  const FrameFolder& folder;
  std::string_view FrameList::Frame::*stem;

  [[nodiscard]] std::string path(const FrameList::Frame& frame) const { return image_path(folder, frame.*stem); }
};

// By the first readable header: all images of a view have one format.
bool has_grey_of_16_bits(const FrameList& frames, const View& view) {
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const FrameList::Frame frame = frames[i];
    const auto info = imaging::read_image_info(view.path(frame).c_str());
    if (!(frame.*view.stem).empty() && info) {
      return info->bit_depth == kFullBits && info->channels <= 2;
    }
  }
  return false;
}

// From images spread over the recording. Unreadable ones are skipped here, and counted when the recording is played.
int most_used_bits(const FrameList& frames, const View& view, imaging::ImageReader& reader) {
  constexpr std::size_t kFramesLookedAt = 8;
  const std::size_t step = std::max<std::size_t>(1, frames.size() / kFramesLookedAt);
  int most = 0;
  for (std::size_t i = 0; most < kFullBits && i < frames.size(); i += step) {
    if (const FrameList::Frame frame = frames[i]; frame.complete()) {
      most = std::max(most, reader.used_bits(view.path(frame).c_str()).value_or(0));
    }
  }
  return most;
}

// None for images whose files define white.
std::optional<int> found_bits(const Dataset& dataset, const View& view) {
  if (!has_grey_of_16_bits(dataset.frames, view)) {
    return std::nullopt;
  }
  const imaging::ImageReaderConfig config = image_reader_config(dataset);
  Arena arena(imaging::ImageReader::required_bytes(config));
  Result<imaging::ImageReader> reader = imaging::ImageReader::create(config, arena);
  const int used_bits = reader ? most_used_bits(dataset.frames, view, *reader) : 0;
  return used_bits == 0 ? kFullBits : imaging::sample_bits_for(used_bits);
}

/// Assumptions on the values' bits, or what is wrong with them; empty if there is nothing to say. Bits as in
/// found_bits.
std::string bits_note(std::optional<int> left, std::optional<int> right) {
  // Views of one kind of camera may use different bits where one of them sees less light, but hardly a sixteenth.
  constexpr int kUnlike = 4;
  const int most = std::max(left.value_or(0), right.value_or(0));
  const auto of = [](std::optional<int> bits) {
    return bits ? std::to_string(*bits) + " bits in 16" : std::string("the whole range of their format");
  };
  const std::string views = "the left images hold values of " + of(left) + ", the right ones of " + of(right);
  if (left && right && std::abs(*left - *right) >= kUnlike) {
    return views + "; one view is too dark to match the other. Store both with the same bit depth and scale";
  }
  if (most == 0 || most == kFullBits) {
    return "";
  }
  if (!left || !right) {
    return views + "; each view is scaled by its own bit depth. Store both with the same";
  }
  return "the images hold values of " + std::to_string(most) +
         " bits in 16; they are taken for those of a camera of so many bits";
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
  const FrameList& frames = dataset.frames;
  const std::optional<int> left = found_bits(dataset, {frames.left(), &FrameList::Frame::left_stem});
  const std::optional<int> right = found_bits(dataset, {frames.right(), &FrameList::Frame::right_stem});
  if (!left && !right) {
    return;
  }
  dataset.sample_bits = std::max(left.value_or(0), right.value_or(0));
  if (const std::string note = bits_note(left, right); !note.empty()) {
    dataset.notes.push_back(concat(frames.left().folder, ": ", note));
  }
}

}  // namespace kinetrace::hal

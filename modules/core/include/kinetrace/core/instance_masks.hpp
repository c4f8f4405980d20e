// Instance masks that come from outside the program, as run lengths: for a frame number, left or right image.
#pragma once

#include <cstdint>
#include <numeric>
#include <span>

#include "kinetrace/core/detections.hpp"
#include "kinetrace/core/export.hpp"
#include "kinetrace/core/frame.hpp"
#include "kinetrace/core/image_view.hpp"

namespace kinetrace {

/// Class of regions that are neither background nor objects (KITTI MOTS 10000): no features there, no track.
inline constexpr std::uint16_t kIgnoreClass = 10;

/// One instance. `runs` are lengths in its box, row by row, outside and inside the mask by turns, beginning outside; a
/// run may go on in the next row, and may have length 0.
struct RunLengthMask {
  std::uint16_t class_id = kUnknownClass;
  float score = 1.F;
  PixelBox box_px;
  std::span<const std::uint16_t> runs;
};

/// True if the box lies in an image of this size and the runs add up to it.
[[nodiscard]] inline bool fits(const RunLengthMask& mask, int width_px, int height_px) noexcept {
  const PixelBox& box = mask.box_px;
  if (box.empty() || box.x0 < 0 || box.y0 < 0 || box.x1 > width_px || box.y1 > height_px) {
    return false;
  }
  const std::uint64_t area = static_cast<std::uint64_t>(box.width()) * static_cast<std::uint64_t>(box.height());
  return std::accumulate(mask.runs.begin(), mask.runs.end(), std::uint64_t{0}) == area;
}

enum class View : std::uint8_t { kLeft, kRight };

/// Masks of one image, or a piece of them, as somebody sent them: nothing is checked.
struct MaskMessage {
  std::uint64_t sender = 0;  ///< The same for all that one sender writes, and for nobody else's.
  std::int64_t frame_index = 0;
  std::int64_t timestamp_ns = 0;  ///< As in the request for this frame.
  View view = View::kLeft;
  std::uint32_t width_px = 0;
  std::uint32_t height_px = 0;
  std::uint32_t piece = 0;   ///< Of the image's masks, from 0 ...
  std::uint32_t pieces = 1;  ///< ... to this.
  std::span<const RunLengthMask> masks;
};

/// Says that masks of a frame are wanted, to whoever makes them.
struct MaskRequest {
  std::int64_t frame_index = 0;
  std::int64_t timestamp_ns = 0;
  std::uint32_t width_px = 0;  ///< Of the rectified images.
  std::uint32_t height_px = 0;
  bool right = false;  ///< Of the right image too.
};

/// Masks of one frame, whole and checked: every mask `fits`. Earlier masks lie over later ones.
struct MaskSet {
  std::span<const RunLengthMask> left;
  std::span<const RunLengthMask> right;  ///< Only where they were wanted.
};

/// Where a segmenter gets masks that somebody else makes. Implemented by whoever has a clock and threads.
class KINETRACE_API MaskSource {
 public:
  MaskSource() = default;
  MaskSource(const MaskSource&) = delete;
  MaskSource& operator=(const MaskSource&) = delete;
  MaskSource(MaskSource&&) = delete;
  MaskSource& operator=(MaskSource&&) = delete;
  virtual ~MaskSource() = default;

  /// Asks for the masks of a frame, as early as the frame is known; does not wait.
  virtual void request(const RectifiedPair& pair) noexcept = 0;
  /// Waits for the masks of the frame that was asked for last, as long as the source allows. Null: none came. Valid
  /// until the next call.
  [[nodiscard]] virtual const MaskSet* await(std::int64_t frame_index) noexcept = 0;
};

/// What has become of a frame whose masks take longer.
struct DelayedMasks {
  bool done = false;               ///< False: still worked on.
  const MaskSet* masks = nullptr;  ///< Null where that failed.
};

/// Where a segmenter gets masks that take longer than a frame. Works on one frame at a time. Implemented by whoever has
/// a clock and threads.
class KINETRACE_API DelayedMaskSource {
 public:
  DelayedMaskSource() = default;
  DelayedMaskSource(const DelayedMaskSource&) = delete;
  DelayedMaskSource& operator=(const DelayedMaskSource&) = delete;
  DelayedMaskSource(DelayedMaskSource&&) = delete;
  DelayedMaskSource& operator=(DelayedMaskSource&&) = delete;
  virtual ~DelayedMaskSource() = default;

  /// Hands a frame over; called only when nothing is worked on. Copies what it needs, does not wait for more.
  /// `region_px`: the part of the left image to look at, and nothing else; empty: all there is to look at.
  virtual void offer(const RectifiedPair& pair, const PixelBox& region_px) noexcept = 0;
  /// The masks of the frame that was handed over. Whether to wait for them is the source's
  /// business. Valid until the next call.
  [[nodiscard]] virtual DelayedMasks take() noexcept = 0;
};

/// Who makes masks elsewhere; all outlive whoever takes masks.
struct MaskMakers {
  MaskSource* external = nullptr;        ///< Another process.
  DelayedMaskSource* network = nullptr;  ///< A neural network in this one.
};

}  // namespace kinetrace

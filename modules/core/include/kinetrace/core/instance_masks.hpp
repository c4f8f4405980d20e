// Instance masks from outside the program, as run lengths, by frame number and view.
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

/// One instance. `runs` are lengths in its box, row by row, alternately outside and inside the mask, beginning outside;
/// a run may continue in the next row, and may have length 0.
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

/// Masks of one image, or a piece of them, as received: unchecked.
struct MaskMessage {
  std::uint64_t sender = 0;  ///< Unique to the sender, the same in all its messages.
  std::int64_t frame_index = 0;
  std::int64_t timestamp_ns = 0;  ///< As in the request for this frame.
  View view = View::kLeft;
  std::uint32_t width_px = 0;
  std::uint32_t height_px = 0;
  std::uint32_t piece = 0;   ///< Index of this part of the image's masks, from 0...
  std::uint32_t pieces = 1;  ///< ...of so many.
  std::span<const RunLengthMask> masks;
};

/// Request for the masks of a frame, to the process that makes them.
struct MaskRequest {
  std::int64_t frame_index = 0;
  std::int64_t timestamp_ns = 0;
  std::uint32_t width_px = 0;  ///< Of the rectified images.
  std::uint32_t height_px = 0;
  bool right = false;  ///< Masks of the right image are wanted, too.
};

/// Masks of one frame, complete and checked: every mask `fits`. Earlier masks lie over later ones.
struct MaskSet {
  std::span<const RunLengthMask> left;
  std::span<const RunLengthMask> right;  ///< Only if requested.
};

/// Source of masks made elsewhere, for a segmenter. Implementations own a clock and threads.
class KINETRACE_API MaskSource {
 public:
  MaskSource() = default;
  MaskSource(const MaskSource&) = delete;
  MaskSource& operator=(const MaskSource&) = delete;
  MaskSource(MaskSource&&) = delete;
  MaskSource& operator=(MaskSource&&) = delete;
  virtual ~MaskSource() = default;

  /// Requests the masks of a frame as soon as the frame is known; does not wait.
  virtual void request(const RectifiedPair& pair) noexcept = 0;
  /// Waits for the masks of the frame requested last, as long as the source allows. Null: none arrived. Valid until the
  /// next call.
  [[nodiscard]] virtual const MaskSet* await(std::int64_t frame_index) noexcept = 0;
};

/// State of a frame whose masks take longer than a frame.
struct DelayedMasks {
  bool done = false;               ///< False: in progress.
  const MaskSet* masks = nullptr;  ///< Null on failure.
};

/// Source of masks that take longer than a frame, for a segmenter. Works on one frame at a time. Implementations own a
/// clock and threads.
class KINETRACE_API DelayedMaskSource {
 public:
  DelayedMaskSource() = default;
  DelayedMaskSource(const DelayedMaskSource&) = delete;
  DelayedMaskSource& operator=(const DelayedMaskSource&) = delete;
  DelayedMaskSource(DelayedMaskSource&&) = delete;
  DelayedMaskSource& operator=(DelayedMaskSource&&) = delete;
  virtual ~DelayedMaskSource() = default;

  /// Submits a frame; called only while idle. Copies the input, does not wait for the result. `region_px`: the only
  /// part of the left image to be searched; empty: whole images.
  virtual void offer(const RectifiedPair& pair, const PixelBox& region_px) noexcept = 0;
  /// The masks of the submitted frame. The source decides whether to wait for them. Valid until the next call.
  [[nodiscard]] virtual DelayedMasks take() noexcept = 0;
};

/// External sources of masks; all outlive the pipeline.
struct MaskMakers {
  MaskSource* external = nullptr;        ///< Another process.
  DelayedMaskSource* network = nullptr;  ///< A neural network in this one.
};

}  // namespace kinetrace

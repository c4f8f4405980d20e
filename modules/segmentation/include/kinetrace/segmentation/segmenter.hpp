// Interface of all sources of instance masks.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/detections.hpp"
#include "kinetrace/core/feature_frame.hpp"
#include "kinetrace/core/frame.hpp"
#include "kinetrace/core/instance_masks.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/core/se3.hpp"
#include "kinetrace/core/track_frame.hpp"
#include "kinetrace/core/workers.hpp"
#include "kinetrace/segmentation/config.hpp"

namespace kinetrace::segmentation {

/// Input of a segmenter: the frame, its features and the ego motion.
struct SegmentationInput {
  RectifiedPair pair;
  std::span<const Feature> features;  ///< Tracked into this frame and stereo-matched; `body` is the label in the
                                      ///< previous frame.
  bool ego_valid = false;             ///< False: no ego motion for this frame (lost, or the very first frame).
  Se3 T_prev_cam;                     ///< Left camera of this frame in the left camera of the previous frame.
  bool is_cut = false;                ///< Scene differs from the frame before: masks of earlier ones are void.
};

/// Running totals since start (reset() keeps them).
struct SegmentationCounters {
  std::uint64_t frames = 0;              ///< Frames processed.
  std::uint64_t frames_missing = 0;      ///< Frames without mask file, ego motion or masks in time.
  std::uint64_t frames_unreadable = 0;   ///< Frames whose left mask file is unusable: damaged, wrong size.
  std::uint64_t files_unreadable = 0;    ///< Unusable mask files of both views.
  std::uint64_t detections = 0;          ///< Left instances delivered.
  std::uint64_t detections_dropped = 0;  ///< Instances beyond max_objects or below min_area_px, both images.
};

class Segmenter {
 public:
  Segmenter() = default;
  Segmenter(const Segmenter&) = delete;
  Segmenter& operator=(const Segmenter&) = delete;
  Segmenter(Segmenter&&) = delete;
  Segmenter& operator=(Segmenter&&) = delete;
  virtual ~Segmenter() = default;

  /// Reads or requests masks from outside the program (mask files); part of capture, not of segmentation. `tracks`:
  /// state of the frame before. Bad or missing files are no error: they are counted, and the frame's detections are not
  /// available.
  virtual void load(const RectifiedPair& /*pair*/, std::span<const Track> /*tracks*/) {}

  /// Instances of this frame; views live in the segmenter until the next call. Errors: kIllegalState if
  /// load() was not called for this frame by a source that needs it.
  [[nodiscard]] virtual Result<DetectionFrame> process(const SegmentationInput& input) = 0;

  /// Clears all state of earlier frames.
  virtual void reset() = 0;

  [[nodiscard]] const SegmentationCounters& counters() const noexcept { return counters_; }

  /// The first few warnings, one line each; index below warning_count().
  [[nodiscard]] virtual std::size_t warning_count() const noexcept { return 0; }
  [[nodiscard]] virtual std::string_view warning(std::size_t /*index*/) const noexcept { return {}; }

 protected:
  SegmentationCounters counters_;
};

/// Bytes that make_segmenter takes from the arena. `max_features` = feature slots (Feature::slot is below it).
[[nodiscard]] std::size_t required_bytes(const SegmentationConfig& config, const StereoGeometry& geometry,
                                         int max_features);

/// The segmenter that `config.mode` names; kAuto without a network: motion alone. `workers`, if any, share its work,
/// and must outlive it. Errors: kInvalidConfig, kNotFound
/// (mask folder), kCapacity (arena).
[[nodiscard]] Result<std::unique_ptr<Segmenter>> make_segmenter(const SegmentationConfig& config,
                                                                const StereoGeometry& geometry, int max_features,
                                                                Arena& arena, const MaskMakers& makers = {},
                                                                Workers* workers = nullptr);

}  // namespace kinetrace::segmentation

// State of one track.
#pragma once

#include <array>
#include <cstdint>

#include "kinetrace/core/detections.hpp"
#include "kinetrace/core/dwell_time.hpp"
#include "kinetrace/core/track_frame.hpp"
#include "kinetrace/tracking/disparity_plane.hpp"
#include "kinetrace/tracking/label_overlap.hpp"
#include "kinetrace/tracking/life_cycle.hpp"
#include "kinetrace/tracking/prediction.hpp"
#include "kinetrace/tracking/reference_mask.hpp"
#include "kinetrace/tracking/similarity.hpp"

namespace kinetrace::tracking {

/// Longest gap between detections that features bridge; after a longer one they lie on the occluder, or on no object.
inline constexpr std::int64_t kMaxFeatureGap_ns = 100'000'000;

/// An unknown class agrees with every class.
[[nodiscard]] inline bool classes_agree(std::uint16_t a, std::uint16_t b) noexcept {
  return a == b || a == kUnknownClass || b == kUnknownClass;
}

/// Majority over the classes of all matched detections. A class beyond the fourth is not counted.
class ClassVotes {
 public:
  void add(std::uint16_t class_id) noexcept;
  /// The class with most votes, the earliest among equals. Unknown loses against any known class.
  [[nodiscard]] std::uint16_t winner() const noexcept;

 private:
  struct Vote {
    std::uint16_t class_id = 0;
    int count = 0;
  };
  std::array<Vote, 4> votes_{};
};

/// Detections under an object's features that were tracked into this frame.
struct FeatureVotes {
  int total = 0;
  std::array<std::uint16_t, 256> on_label{};  ///< By the label of the detection under them.
};

/// One slot of the tracker.
struct TrackInstance {
  LifeState life = LifeState::kFree;
  bool terminated = false;  ///< Has switched to another object: ends with the next frame.
  int matched_frames = 0;
  Track track;
  DwellTime age;
  DwellTime missed;           ///< Without a detection.
  DwellTime missed_searched;  ///< Of that, in frames searched for it.
  DwellTime missed_in_sight;  ///< Of that, where a detection was expected.
  std::int64_t matched_timestamp_ns = 0;
  ClassVotes votes;

  ReferenceMask mask;
  ObjectPrediction prediction;                 ///< Of the current frame.
  ObjectPrediction previous_prediction;        ///< Of the previous frame.
  ObjectPrediction mask_prediction;            ///< Of the frame that `mask` was taken from.
  Similarity motion;                           ///< Image motion into the current frame.
  bool motion_from_flow = false;               ///< `motion` comes from features of this frame.
  DisparityPlane disparity;                    ///< Last known.
  double mask_part_in_image = 1.0;             ///< Of the predicted mask.
  int misses = 0;                              ///< Frames searched for it without success since its last detection,
  int earlier_misses = 0;                      ///< ... and before.
  int predicted_px = 0;                        ///< Pixels of the predicted mask in the image, occluded ones included.
  std::array<int, 256> whole_mask_on_label{};  ///< Pixels of the whole predicted mask, by the label of the detection.
  std::uint64_t occluder_slots = 0;            ///< Bit s: the track in slot s was observed to occlude this one.
  PredictionOverlap overlap;                   ///< Visible part of the predicted mask against the detections.
  FeatureVotes feature_votes;
  int detection = -1;                   ///< Index of the matched left detection.
  double right_visible_fraction = 1.0;  ///< Of the predicted mask, in the right view; 1 without a disparity.
  PixelBox right_region_px;             ///< Of the left mask mapped to the right image: its visible extent.

  [[nodiscard]] bool alive() const noexcept { return is_alive(life); }
  /// Searched for without success for longer than features bridge, and in more frames than chance explains, given how
  /// reliably it was detected before.
  [[nodiscard]] bool is_mask_lost() const noexcept;
  [[nodiscard]] bool tentative() const noexcept { return life == LifeState::kTentative; }
};

}  // namespace kinetrace::tracking

// Everything the tracker remembers about one object.
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

/// Features carry a track over so long a break in its detections; after a longer one they lie on what hides it, or on
/// nothing.
inline constexpr std::int64_t kCarriedByFeatures_ns = 100'000'000;

/// Unknown agrees with every class.
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

/// Where the features that an object's motion carried into this frame have landed.
struct FeatureVotes {
  int total = 0;
  std::array<std::uint16_t, 256> on_label{};  ///< By the label of the detection under them.
};

/// One slot of the tracker.
struct TrackInstance {
  LifeState life = LifeState::kFree;
  bool terminated = false;  ///< Has passed to another object: ends with the next frame.
  int matched_frames = 0;
  Track track;
  DwellTime age;
  DwellTime missed;            ///< Without a detection.
  DwellTime tentative_missed;  ///< Of that, where it was looked for.
  DwellTime missed_in_sight;   ///< Of that, where a detection could be expected.
  std::int64_t matched_timestamp_ns = 0;
  ClassVotes votes;

  ReferenceMask mask;
  ObjectPrediction prediction;           ///< Of the current frame.
  ObjectPrediction previous_prediction;  ///< Of the frame before.
  ObjectPrediction mask_prediction;      ///< Of the frame that `mask` was taken from.
  Similarity motion;                     ///< Image motion into the current frame.
  bool motion_from_flow = false;         ///< `motion` comes from features of this frame.
  DisparityPlane disparity;              ///< Last known.
  double mask_part_in_image = 1.0;       ///< Of the predicted mask.
  int predicted_px = 0;                  ///< Pixels of the predicted mask in the image, hidden ones included.
  std::array<int, 256>
      whole_on_label{};        ///< Pixels of the whole predicted mask on each detection, hidden ones included.
  std::uint64_t in_front = 0;  ///< Bit s: the track in slot s has been seen to hide this one.
  PredictionOverlap overlap;   ///< Visible part of the predicted mask against the detections.
  FeatureVotes votes_of_features;
  int detection = -1;        ///< Index of the matched left detection.
  double right_shown = 1.0;  ///< Part of the predicted mask seen by the right view; 1 while its disparity is not known.
  PixelBox right_region_px;  ///< Of the left mask carried to the right image: what is seen of it there.

  [[nodiscard]] bool alive() const noexcept { return is_alive(life); }
  [[nodiscard]] bool tentative() const noexcept { return life == LifeState::kTentative; }
};

}  // namespace kinetrace::tracking

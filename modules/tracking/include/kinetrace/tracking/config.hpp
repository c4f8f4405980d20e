// Limits and thresholds of the object tracker.
#pragma once

#include "kinetrace/core/export.hpp"
#include "kinetrace/core/image_view.hpp"
#include "kinetrace/core/result.hpp"

namespace kinetrace::tracking {

struct KINETRACE_API TrackerConfig {
  int max_objects = 24;  ///< Tracks alive at once, [1, kMaxObjects].
  /// Matched frames, birth included, until a track is confirmed. Not a time: each detection is one more piece of
  /// evidence, and a false alarm does not become an object by lasting.
  int confirm_frames = 3;
  double max_missed_s = 1.0;  ///< A track without a detection shows its prediction for so long; one whose place is
                              ///< not known ends then.
  double max_unseen_s = 7.5;  ///< One whose place is known waits so much longer to be found again.
  double max_tentative_missed_s = 0.1;  ///< The same for a tentative track; only frames with detections count.
  int min_area_px = 64;                 ///< Smaller detections are not born; smaller tracks end.
  double min_overlap = 0.15;            ///< Right masks: intersection over union below this is no match.
  double duplicate_overlap = 0.6;       ///< A detection with this share of its pixels on live tracks is not born.
  double ransac_threshold_px = 2.0;     ///< Features within this of an object's similarity support it.
  int ransac_iterations = 48;

  [[nodiscard]] Status validate() const;
};

}  // namespace kinetrace::tracking

// Limits and thresholds of the object tracker.
#pragma once

#include "kinetrace/core/export.hpp"
#include "kinetrace/core/image_view.hpp"
#include "kinetrace/core/result.hpp"

namespace kinetrace::tracking {

struct KINETRACE_API TrackerConfig {
  int max_objects = 24;  ///< Tracks alive at once, [1, kMaxObjects].
  /// Matched frames, the first included, that confirm a track. A count, not a time: each detection adds evidence, the
  /// age of a false alarm does not.
  int confirm_frames = 3;
  double max_missed_s = 1.0;  ///< A track without a detection coasts, with its mask, for this time; without a predicted
                              ///< position it ends then.
  double max_unseen_s = 7.5;  ///< A track with a predicted position waits this much longer for re-detection.
  double max_tentative_missed_s = 0.1;  ///< The same for a tentative track, in frames searched for it.
  int min_area_px = 64;                 ///< Smaller detections initiate no track; smaller tracks end.
  double min_overlap = 0.15;            ///< Right masks: intersection over union below this is no match.
  double duplicate_overlap = 0.6;       ///< A detection with this share of its pixels on a live track initiates none.
  double ransac_threshold_px = 2.0;     ///< Inlier threshold of an object's similarity.
  int ransac_iterations = 48;

  [[nodiscard]] Status validate() const;
};

}  // namespace kinetrace::tracking

#include "kinetrace/tracking/config.hpp"

#include "kinetrace/core/config_check.hpp"

namespace kinetrace::tracking {

Status TrackerConfig::validate() const {
  return first_failure({
      check_range("tracking.max_objects", max_objects, 1, kMaxObjects),
      check_range("tracking.confirm_frames", confirm_frames, 1, 100),
      check_range("tracking.max_missed_s", max_missed_s, 0.0, 100.0),
      check_range("tracking.max_unseen_s", max_unseen_s, 0.0, 10000.0),
      check_range("tracking.max_tentative_missed_s", max_tentative_missed_s, 0.0, 100.0),
      check_range("tracking.min_area_px", min_area_px, 1, 1000000),
      check_range("tracking.min_overlap", min_overlap, 0.01, 1.0),
      check_range("tracking.duplicate_overlap", duplicate_overlap, 0.01, 1.0),
      check_range("tracking.ransac_threshold_px", ransac_threshold_px, 0.1, 20.0),
      check_range("tracking.ransac_iterations", ransac_iterations, 1, 1000),
  });
}

}  // namespace kinetrace::tracking

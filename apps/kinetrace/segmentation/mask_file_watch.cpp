#include "segmentation/mask_file_watch.hpp"

#include <string>

namespace kinetrace::app {

Status MaskFileWatch::process(const FrameCounters& counters, std::int64_t timestamp_ns, std::string_view complaint,
                              HealthMonitor& health, const Warn& warn) {
  health.note(HealthReason::kMasksMissing, counters.detection_frames_missing - last_.detection_frames_missing);
  health.note(HealthReason::kMasksUnreadable, counters.mask_files_unreadable - last_.mask_files_unreadable);
  last_ = counters;
  first_ns_ = first_ns_.value_or(timestamp_ns);
  if (counters.mask_files_unreadable > 0 && !said_unreadable_) {
    said_unreadable_ = true;
    warn("a mask file cannot be used, and its frame has no detections: " + std::string(complaint));
  }
  if (assessed_ || timestamp_ns - *first_ns_ < kAssessed_ns) {
    return {};
  }
  assessed_ = true;
  if (counters.detection_frames_missing < counters.frames) {
    return {};
  }
  if (counters.mask_files_unreadable > 0) {
    return none_fits(complaint, warn);
  }
  warn("not one frame so far has a mask file: " + std::string(complaint) +
       "; mask files are named like the left images");
  return {};
}

Status MaskFileWatch::finish(std::string_view complaint, const Warn& warn) const {
  if (last_.frames == 0 || last_.detection_frames_missing < last_.frames) {
    return {};
  }
  return none_fits(complaint, warn);
}

Status MaskFileWatch::none_fits(std::string_view complaint, const Warn& warn) const {
  std::string what = "not one mask of " + std::to_string(last_.frames) +
                     " frames can be used: " + std::string(complaint) +
                     "; masks are PNG files of the rectified images' size, named like the left images";
  if (policy_ == InputPolicy::kWarn) {
    warn(what);
    return {};
  }
  return fail(ErrorCode::kBadFormat, std::move(what));
}

}  // namespace kinetrace::app

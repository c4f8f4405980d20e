#include "kinetrace/tracking/track_instance.hpp"

#include <cmath>

#include "kinetrace/core/detections.hpp"

namespace kinetrace::tracking {

bool TrackInstance::is_mask_lost() const noexcept {
  constexpr double kSignificance = 0.05;  // Of so many misses in a row, if it were there.
  const double miss_probability = (earlier_misses + 1.0) / (matched_frames + earlier_misses + 2.0);
  return missed_searched.exceeds(kMaxFeatureGap_ns) && std::pow(miss_probability, misses) < kSignificance;
}

void ClassVotes::add(std::uint16_t class_id) noexcept {
  for (Vote& vote : votes_) {
    if (vote.count == 0 || vote.class_id == class_id) {
      vote.class_id = class_id;
      ++vote.count;
      return;
    }
  }
}

std::uint16_t ClassVotes::winner() const noexcept {
  Vote best{kUnknownClass, 0};
  for (const Vote& vote : votes_) {
    if (vote.class_id != kUnknownClass && vote.count > best.count) {
      best = vote;
    }
  }
  return best.class_id;
}

}  // namespace kinetrace::tracking

#include "kinetrace/tracking/track_instance.hpp"

#include "kinetrace/core/detections.hpp"

namespace kinetrace::tracking {

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

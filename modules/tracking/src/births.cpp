// The part of StereoTracker that initiates, splits and evicts tracks.
#include <algorithm>
#include <array>
#include <tuple>

#include "kinetrace/tracking/stereo_tracker.hpp"

namespace kinetrace::tracking {
void StereoTracker::initiate_tracks(const DetectionFrame& detections, std::span<const Feature> features) {
  counters_.detections += owner_.size();
  std::array<std::uint8_t, kMaxObjects> order{};
  std::size_t unassigned = 0;
  for (std::size_t v = 0; v < owner_.size(); ++v) {
    if (owner_[v] < 0) {
      order[unassigned++] = static_cast<std::uint8_t>(v);
    }
  }
  std::sort(order.begin(), order.begin() + unassigned, [&](std::uint8_t a, std::uint8_t b) {
    const int area_a = detections.left[a].area_px;
    const int area_b = detections.left[b].area_px;
    return area_a != area_b ? area_a > area_b : a < b;
  });
  for (std::size_t i = 0; i < unassigned; ++i) {
    const std::size_t v = order[i];
    const Detection& detection = detections.left[v];
    if (detection.area_px < config_.min_area_px) {
      ++counters_.detections_dropped;
    } else if (is_duplicate(detection, gather_samples(detections.left_labels, detection.label, features))) {
      ++counters_.detections_duplicate;
    } else if (!start_track(detections, v)) {
      ++counters_.detections_dropped;
      evict_track(detection.area_px);
    }
  }
}

bool StereoTracker::is_duplicate(const Detection& detection, std::span<const DisparitySample> samples) const noexcept {
  return std::any_of(slots_.begin(), slots_.end(), [&](const TrackInstance& instance) {
    const bool is_on_it = instance.overlap.on_label[detection.label] >= config_.duplicate_overlap * detection.area_px;
    return instance.alive() && is_assignable(instance) && classes_agree(instance.track.class_id, detection.class_id) &&
           (is_on_it || is_moving_part(instance, detection, samples));
  });
}

bool StereoTracker::is_moving_part(const TrackInstance& instance, const Detection& detection,
                                   std::span<const DisparitySample> samples) noexcept {
  const bool is_region_on_object = detection.class_id == kUnknownClass && instance.track.class_id != kUnknownClass;
  return is_region_on_object && instance.detection >= 0 && part_evidence(instance, detection, samples) > 0.0;
}

TrackInstance* StereoTracker::free_instance() noexcept {
  const auto found = std::find_if(slots_.begin(), slots_.end(),
                                  [](const TrackInstance& instance) { return instance.life == LifeState::kFree; });
  return found == slots_.end() || alive() >= max_tracks_ ? nullptr : found;
}

void StereoTracker::initiate(TrackInstance& instance, std::uint16_t class_id) noexcept {
  const auto slot = static_cast<std::uint8_t>(&instance - slots_.begin());
  const ReferenceMask mask = instance.mask;
  const PixelBox box_px = instance.track.box_px;
  const int area_px = instance.track.area_px;
  const int detection = instance.detection;
  instance = {};
  instance.mask = mask;
  instance.detection = detection;
  instance.life = config_.confirm_frames == 1 ? LifeState::kConfirmed : LifeState::kTentative;
  for (TrackInstance& other : slots_) {
    other.occluder_slots &= ~(std::uint64_t{1} << slot);
  }
  instance.track.id = next_id_++;
  instance.track.slot = slot;
  instance.track.state = track_state(instance.life);
  instance.track.box_px = box_px;
  instance.track.area_px = area_px;
  instance.matched_frames = 1;
  instance.matched_timestamp_ns = timestamp_ns_;
  instance.age.add_frame(interval_ns_);
  instance.track.age_ns = instance.age.ns();
  instance.votes.add(class_id);
  instance.track.class_id = instance.votes.winner();
  ++counters_.born;
  counters_.confirmed += instance.tentative() ? 0U : 1U;
}

bool StereoTracker::start_track(const DetectionFrame& detections, std::size_t index) noexcept {
  TrackInstance* const instance = free_instance();
  if (instance == nullptr) {
    return false;
  }
  instance->detection = static_cast<int>(index);
  initiate(*instance, detections.left[index].class_id);
  owner_[index] = instance->track.slot;
  return true;
}

std::optional<std::uint8_t> StereoTracker::split_track(std::uint8_t slot, const Track& before) noexcept {
  TrackInstance* const dormant = free_instance();
  if (dormant == nullptr) {
    return std::nullopt;
  }
  TrackInstance& detected = slots_[slot];
  const std::uint16_t class_id = detected.track.class_id;
  const ReferenceMask empty = dormant->mask;
  *dormant = detected;
  dormant->mask = empty;
  dormant->mask.capture(left_, {}, [](std::uint8_t, int, int) { return false; });
  dormant->life = LifeState::kDormant;
  dormant->detection = -1;
  --dormant->matched_frames;
  const std::int64_t missed_ns = before.missed_ns + interval_ns_;
  dormant->missed = {};
  dormant->missed.add_frame(2 * missed_ns);  // the first frame counts half
  dormant->matched_timestamp_ns = timestamp_ns_ - missed_ns;
  dormant->track = before;
  dormant->track.slot = static_cast<std::uint8_t>(dormant - slots_.begin());
  dormant->track.state = track_state(dormant->life);
  ++dormant->track.missed_frames;
  dormant->track.missed_ns = missed_ns;
  dormant->track.box_px = {};
  dormant->track.area_px = 0;
  initiate(detected, class_id);
  const auto published =
      std::find_if(published_.begin(), published_.end(), [slot](const Track& track) { return track.slot == slot; });
  *published = detected.track;
  (void)published_.push_back(dormant->track);  // as many places as slots
  sort_published();
  return dormant->track.slot;
}

int StereoTracker::alive() const noexcept {
  return static_cast<int>(
      std::count_if(slots_.begin(), slots_.end(), [](const TrackInstance& instance) { return instance.alive(); }));
}

void StereoTracker::prune_to_capacity() noexcept {
  // The longest undetected first, then the smallest.
  const auto goes_before = [](const TrackInstance& a, const TrackInstance& b) {
    const auto rank = [](const TrackInstance& instance) {
      return std::tuple(!instance.alive(), -instance.track.missed_frames, instance.track.area_px);
    };
    return rank(a) < rank(b);
  };
  for (int count = alive(); count > max_tracks_; --count) {
    end(*std::min_element(slots_.begin(), slots_.end(), goes_before));
  }
}

void StereoTracker::evict_track(int for_area_px) noexcept {
  TrackInstance* victim = nullptr;
  TrackInstance* smallest = nullptr;
  const auto rank = [](const TrackInstance& instance) {  // tentative before confirmed, then the longest undetected
    return (instance.tentative() ? 1 << 16 : 0) + instance.track.missed_frames;
  };
  for (TrackInstance& instance : slots_) {
    const bool is_new = instance.track.age_frames == 0;
    if (instance.alive() && !is_new && (smallest == nullptr || instance.track.area_px < smallest->track.area_px)) {
      smallest = &instance;
    }
    if (!instance.alive() || instance.detection >= 0 ||
        (!instance.tentative() && !instance.missed.exceeds(limits_.missed_ns / 2))) {
      continue;
    }
    if (victim == nullptr || rank(instance) > rank(*victim)) {
      victim = &instance;
    }
  }
  if (victim == nullptr && smallest != nullptr && for_area_px > 2 * smallest->track.area_px) {
    victim = smallest;
  }
  if (victim != nullptr) {
    if (victim->detection >= 0) {
      owner_[static_cast<std::size_t>(victim->detection)] = -1;
    }
    end(*victim);
  }
}

}  // namespace kinetrace::tracking

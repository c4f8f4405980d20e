#include "kinetrace/segmentation/mask_fusion.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <tuple>

#include "kinetrace/segmentation/person_size.hpp"

namespace kinetrace::segmentation {
namespace {

// Logistic regression on six simulated worlds unused in the development of the network and of motion segmentation
// (street, drone and wearable, seeds 601 and 602, 1000 frames, 7368 candidates down to a score of .05, with the network
// that comes with Kinetrace). A candidate is an object if the IoU of its mask with a true one is at least one half.

/// Added to a candidate's own log-odds for a moving region of the same pixels, in proportion to their IoU. A lack of
/// motion is no evidence: the object may stand.
constexpr float kMotionNats = 3.7F;
/// Log-odds of a region without a candidate; most of its pixels are an object's in 109 of 194.
constexpr float kRegionNats = 0.3F;
/// Per part of a region under accepted candidates: log-odds are zero at a quarter. With more, the remainder of the
/// region was mostly background in 1467 of 2257 regions, more of the candidate's object in 775, another object in 15:
/// it is dropped.
constexpr float kCoveredNats = -1.2F;

constexpr int kRows = kMaxObjects + 2;     // Background, candidates, ignored pixels.
constexpr int kColumns = kMaxObjects + 1;  // Background, regions.

int row_of(std::uint8_t label) noexcept {
  return label == kIgnoreLabel ? kRows - 1 : label;
}

/// Calls visit(x0, x1) for each run of pixels with constant labels in both rows, except background in both.
template <typename Visit>
void for_each_run_of_row(const std::uint8_t* network, const std::uint8_t* motion, int width, Visit&& visit) noexcept {
  constexpr int kAtOnce = 8;
  int x = 0;
  while (x < width) {
    std::uint64_t seen = 0;
    std::uint64_t moving = 0;
    if (x + kAtOnce <= width) {  // most of an image is background
      std::memcpy(&seen, network + x, sizeof seen);
      std::memcpy(&moving, motion + x, sizeof moving);
      if ((seen | moving) == 0) {
        x += kAtOnce;
        continue;
      }
    }
    const int start = x;
    while (x < width && network[x] == network[start] && motion[x] == motion[start]) {
      ++x;
    }
    if (network[start] != kBackgroundLabel || motion[start] != kBackgroundLabel) {
      visit(start, x);
    }
  }
}

float probability_of(float log_odds) noexcept {
  return 1.F / (1.F + std::exp(-log_odds));
}

/// Bounds the evidence to one to a thousand, either way.
float log_odds_of(float probability) noexcept {
  constexpr float kMinProbability = 0.001F;
  const float p = std::clamp(probability, kMinProbability, 1.F - kMinProbability);
  return std::log(p / (1.F - p));
}

}  // namespace

MaskFusion::MaskFusion(const StereoGeometry& geometry, int max_objects, int min_area_px, Arena& arena)
    : min_area_px_(min_area_px),
      baseline_m_(static_cast<float>(geometry.baseline_m)),
      labels_(take_image<std::uint8_t>(arena, geometry.width_px, geometry.height_px)),
      detections_(arena, static_cast<std::size_t>(max_objects)),
      objects_(arena, std::size_t{2} * kMaxObjects),
      blank_row_(arena.take<std::uint8_t>(static_cast<std::size_t>(geometry.width_px))),
      shared_px_(take_image<std::int32_t>(arena, kColumns, kRows)),
      label_of_(take_image<std::uint8_t>(arena, kColumns, kRows)) {}

int MaskFusion::fuse(const LabelledInstances& network, const LabelledInstances& motion) noexcept {
  for (int row = 0; row < kRows; ++row) {
    std::fill_n(shared_px_.row(row), kColumns, 0);
  }
  for_each_run(network.labels, motion.labels,
               [&](int row, int column, int, int x0, int x1) { shared_px_.row(row)[column] += x1 - x0; });
  objects_.clear();
  accept_candidates(network.instances, motion.instances);
  accept_regions(motion);
  const int dropped = number_objects();
  draw(network.labels, motion.labels);
  return dropped;
}

template <typename Visit>
void MaskFusion::for_each_run(LabelView network, LabelView motion, Visit&& visit) const noexcept {
  for (int y = 0; y < labels_.height; ++y) {
    const std::uint8_t* const seen = network.empty() ? blank_row_.data() : network.row(y);
    const std::uint8_t* const moving = motion.empty() ? blank_row_.data() : motion.row(y);
    for_each_run_of_row(seen, moving, labels_.width,
                        [&](int x0, int x1) { visit(row_of(seen[x0]), static_cast<int>(moving[x0]), y, x0, x1); });
  }
}

void MaskFusion::accept_candidates(std::span<const Detection> candidates, std::span<const Detection> regions) noexcept {
  for (const Detection& candidate : candidates) {
    const std::int32_t* const shared_px = shared_px_.row(candidate.label);
    float fit = 0.F;
    bool moving = false;
    for (const Detection& region : regions) {
      const int both_px = shared_px[region.label];
      fit =
          std::max(fit, static_cast<float>(both_px) / static_cast<float>(candidate.area_px + region.area_px - both_px));
      moving = moving || (region.moving && 2 * both_px > candidate.area_px);
    }
    const float log_odds = log_odds_of(candidate.score) + kMotionNats * fit;
    if (candidate.score >= kMinCandidateProbability && log_odds > 0.F) {
      (void)objects_.push_back({.label = candidate.label,  // room for as many as there are labels, of either kind
                                .class_id = candidate.class_id,
                                .log_odds = log_odds,
                                .area_px = candidate.area_px,
                                .box_px = candidate.box_px,
                                .moving = moving});
    }
  }
}

MaskFusion::Object* MaskFusion::person_with(const Detection& region, float disparity_px) noexcept {
  Object* best = nullptr;
  int best_px = 0;
  for (Object& object : objects_) {
    const int both_px = shared_px_.row(object.label)[region.label];
    if (object.is_region || object.class_id != kPedestrianClass || both_px <= best_px) {
      continue;
    }
    PixelBox all = object.box_px;
    all.include(region.box_px.x0, region.box_px.y0);
    all.include(region.box_px.x1 - 1, region.box_px.y1 - 1);
    if (!is_larger_than_people(all, disparity_px, baseline_m_)) {
      best = &object;
      best_px = both_px;
    }
  }
  return best;
}

void MaskFusion::accept_regions(const LabelledInstances& motion) noexcept {
  const std::size_t candidates = objects_.size();
  for (std::size_t r = 0; r < motion.instances.size(); ++r) {
    const Detection& region = motion.instances[r];
    if (Object* const person =
            motion.disparities_px.empty() ? nullptr : person_with(region, motion.disparities_px[r])) {
      person->moving = person->moving || region.moving;
      continue;
    }
    int own_px = region.area_px - shared_px_.row(row_of(kIgnoreLabel))[region.label];
    for (std::size_t k = 0; k < candidates; ++k) {
      own_px -= shared_px_.row(objects_[k].label)[region.label];
    }
    const float covered = 1.F - static_cast<float>(own_px) / static_cast<float>(region.area_px);
    const float log_odds = kRegionNats + kCoveredNats * covered;
    if (log_odds > 0.F) {
      (void)objects_.push_back({.is_region = true,
                                .label = region.label,
                                .class_id = region.class_id,
                                .log_odds = log_odds,
                                .area_px = own_px,
                                .moving = region.moving});
    }
  }
}

// The largest objects stay.
int MaskFusion::number_objects() noexcept {
  std::sort(objects_.begin(), objects_.end(), [](const Object& a, const Object& b) {
    return std::tuple(-a.area_px, a.is_region, a.label) < std::tuple(-b.area_px, b.is_region, b.label);
  });
  detections_.clear();
  int dropped = 0;
  for (Object& object : objects_) {
    if (object.area_px < min_area_px_) {
      ++dropped;
    } else if (detections_.full()) {
      object.result = kIgnoreLabel;
      ++dropped;
    } else {
      object.result = static_cast<std::uint8_t>(detections_.size() + 1);
      (void)detections_.push_back({object.result,
                                   object.class_id,
                                   probability_of(object.log_odds),
                                   {},
                                   object.area_px,
                                   object.moving});  // checked above
    }
  }
  return dropped;
}

void MaskFusion::draw(LabelView network, LabelView motion) noexcept {
  for (int row = 0; row < kRows; ++row) {
    std::fill_n(label_of_.row(row), kColumns, row == row_of(kIgnoreLabel) ? kIgnoreLabel : kBackgroundLabel);
  }
  for (const Object& object : objects_) {
    for (int row = 0; object.is_region && row < row_of(kIgnoreLabel); ++row) {
      label_of_.row(row)[object.label] = object.result;
    }
  }
  for (const Object& object : objects_) {
    if (!object.is_region) {
      std::fill_n(label_of_.row(object.label), kColumns, object.result);
    }
  }
  for (int y = 0; y < labels_.height; ++y) {
    std::fill_n(labels_.row(y), labels_.width, kBackgroundLabel);
  }
  for_each_run(network, motion, [&](int row, int column, int y, int x0, int x1) {
    const std::uint8_t label = label_of_.row(row)[column];
    std::fill(labels_.row(y) + x0, labels_.row(y) + x1, label);
    if (label != kBackgroundLabel && label != kIgnoreLabel) {
      PixelBox& box_px = detections_[label - 1U].box_px;
      box_px.include(x0, y);
      box_px.include(x1 - 1, y);
    }
  });
}

}  // namespace kinetrace::segmentation

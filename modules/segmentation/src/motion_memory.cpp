#include "kinetrace/segmentation/motion_memory.hpp"

#include <algorithm>

#include "velocity_test.hpp"

namespace kinetrace::segmentation {
namespace {

/// Votes that confirm a region: features that agreed with another one, summed over frames. A frame counts at most
/// kMaxVotes, and at least kMinVotes: a cluster of fewer features has the evidence of the images.
constexpr int kConfirmVotes = 8;
constexpr int kMinVotes = 2;
constexpr int kMaxVotes = 6;
/// Least features that retain a halted region.
constexpr int kMinHeldFeatures = 2;
/// Time without motion after which an unconfirmed region is dropped.
constexpr std::int64_t kMaxUnconfirmedGap_ns = 200'000'000;
/// A feature leaves a moving region when rest fits it better by this much.
constexpr float kLeaveChi2 = 4.F;
/// A member that never moved with the region is removed after so much time of unknown motion. One that moved with it
/// gets a whole window: while an object brakes, no constant velocity fits.
constexpr std::int64_t kMaxUnknown_ns = 400'000'000;
constexpr std::int64_t kMaxMovedUnknown_ns = 800'000'000;

}  // namespace

MotionMemory::MotionMemory(const MotionConfig& config, int max_features, Arena& arena)
    : config_(config),
      memory_(arena.take<Membership>(static_cast<std::size_t>(max_features))),
      regions_(arena, kMaxRegions),
      joined_(arena, kMaxRegions),
      region_of_(arena, static_cast<std::size_t>(max_features)),
      region_of_blob_(arena, MovingBlobs::kMaxBlobs),
      has_moved_with_region_(arena, static_cast<std::size_t>(max_features)) {}

void MotionMemory::reset() noexcept {
  std::fill(memory_.begin(), memory_.end(), Membership{});
  regions_.clear();
  joined_.clear();
  region_of_.clear();
  has_moved_with_region_.clear();
  region_of_blob_.clear();
}

void MotionMemory::begin(std::int64_t interval_ns, std::span<const Feature> features,
                         std::span<const std::uint32_t> inherited_region) {
  interval_ns_ = interval_ns;
  recall(features, inherited_region);
}

void MotionMemory::update(std::span<const Feature> features, std::span<const FeatureMotion> motions,
                          std::span<const MotionCluster> clusters, std::span<const std::int16_t> cluster_of_feature,
                          std::span<const std::uint32_t> drawn_region) {
  const std::span<const Feature> known = features.first(motions.size());
  assign_clusters(clusters, cluster_of_feature, drawn_region);
  add_known_features(known, motions, cluster_of_feature);
}

std::int16_t MotionMemory::region_of(std::size_t blob, std::uint32_t drawn_as,
                                     std::span<const std::int16_t> blob_of_feature) const {
  if (const std::int16_t drawn = drawn_as == 0 ? std::int16_t{-1} : index_of(drawn_as); drawn >= 0) {
    return drawn;
  }
  std::array<int, kMaxRegions> votes{};
  for (std::size_t i = 0; i < region_of_.size(); ++i) {
    if (blob_of_feature[i] == static_cast<std::int16_t>(blob) && region_of_[i] >= 0) {
      ++votes[static_cast<std::size_t>(region_of_[i])];
    }
  }
  const auto most = std::max_element(votes.begin(), votes.end());
  return *most >= kMinHeldFeatures ? static_cast<std::int16_t>(most - votes.begin()) : std::int16_t{-1};
}

// A moving blob was observed for some frames already: its region is confirmed. A blob whose cells have changed, without
// a significant velocity, still continues its region.
void MotionMemory::update_blobs(std::span<const MovingBlob> blobs, std::span<const std::uint32_t> drawn_as,
                                std::span<const std::int16_t> blob_of_feature) {
  region_of_blob_.clear();
  for (std::size_t b = 0; b < blobs.size(); ++b) {
    std::int16_t r = region_of(b, drawn_as[b], blob_of_feature);
    if (r < 0 && blobs[b].moving && regions_.push_back({})) {
      r = static_cast<std::int16_t>(regions_.size() - 1);
      regions_.back().id = next_region_id_++;
      regions_.back().moving_frames = config_.confirm_frames;
      regions_.back().votes = kConfirmVotes;
    }
    (void)region_of_blob_.push_back(r);  // at most kMaxBlobs
    if (r < 0 || regions_[static_cast<std::size_t>(r)].moving) {
      continue;
    }
    MotionRegion& region = regions_[static_cast<std::size_t>(r)];
    sustain(static_cast<std::size_t>(r));
    if (blobs[b].moving) {
      ++region.moving_frames;
      region.votes += kMaxVotes;
      region.velocity_mps = blobs[b].velocity_mps;
      region.covariance = blobs[b].covariance();
    }
  }
}

void MotionMemory::sustain(std::size_t region) noexcept {
  regions_[region].moving = true;
}

void MotionMemory::conclude(std::span<const Feature> features, std::span<const FeatureMotion> motions) {
  drop_stale();
  memorise(features.first(motions.size()), motions);
}

void MotionMemory::memorise(std::span<const Feature> features, std::span<const FeatureMotion> motions) {
  for (std::size_t i = 0; i < features.size(); ++i) {
    if (features[i].slot >= memory_.size()) {
      continue;
    }
    Membership& m = memory_[features[i].slot];
    const bool continued = m.feature_id == features[i].id;
    DwellTime unknown = continued && !motions[i].known ? m.unknown : DwellTime{};
    if (!motions[i].known) {
      unknown.add_frame(interval_ns_);
    }
    const std::int64_t timeout_ns = has_moved_with_region(i) ? kMaxMovedUnknown_ns : kMaxUnknown_ns;
    const std::int16_t r = unknown.exceeds(timeout_ns) ? std::int16_t{-1} : region_of_[i];
    m = {features[i].id, r < 0 ? 0U : regions_[static_cast<std::size_t>(r)].id, has_moved_with_region(i), unknown};
  }
}

std::uint32_t MotionMemory::whole_of(std::uint32_t region_id) const noexcept {
  const auto* const found = std::find_if(joined_.begin(), joined_.end(),
                                         [region_id](const JoinedRegion& joined) { return joined.part == region_id; });
  return found == joined_.end() ? region_id : whole_of(found->whole);
}

std::int16_t MotionMemory::index_of(std::uint32_t region_id) const noexcept {
  const std::uint32_t whole_id = whole_of(region_id);
  for (std::size_t r = 0; r < regions_.size(); ++r) {
    if (regions_[r].id == whole_id) {
      return static_cast<std::int16_t>(r);
    }
  }
  return -1;
}

// region_of_ <- each feature's region in the previous frame, or the region on whose mask it was found.
void MotionMemory::recall(std::span<const Feature> features, std::span<const std::uint32_t> inherited_region) {
  region_of_.clear();
  has_moved_with_region_.clear();
  joined_.clear();
  for (std::size_t i = 0; i < features.size(); ++i) {
    const Feature& feature = features[i];
    std::uint32_t region_id = inherited_region[i];
    bool has_moved_with_region = false;
    if (feature.slot < memory_.size() && memory_[feature.slot].feature_id == feature.id) {
      region_id = memory_[feature.slot].region_id;
      has_moved_with_region = memory_[feature.slot].has_moved_with_region;
    }
    // Same capacity as the motions.
    (void)region_of_.push_back(region_id == 0 ? std::int16_t{-1} : index_of(region_id));
    (void)has_moved_with_region_.push_back(has_moved_with_region ? 1 : 0);
  }
  for (MotionRegion& region : regions_) {
    region.moving = false;
    region.features = 0;
  }
}

// Each cluster, the largest first, continues the region that got most votes of its features, if these are at least a
// quarter of them and no cluster of this frame continues that region already; otherwise it begins a new one.
void MotionMemory::assign_clusters(std::span<const MotionCluster> clusters,
                                   std::span<const std::int16_t> cluster_of_feature,
                                   std::span<const std::uint32_t> drawn_region) {
  const std::size_t known_regions = regions_.size();
  for (std::size_t c = 0; c < clusters.size(); ++c) {
    std::array<int, kMaxRegions> votes{};
    for (std::size_t i = 0; i < region_of_.size(); ++i) {
      if (cluster_of_feature[i] != static_cast<std::int16_t>(c)) {
        continue;
      }
      const std::int16_t r = region_of_[i] >= 0 || drawn_region[i] == 0 ? region_of_[i] : index_of(drawn_region[i]);
      if (r >= 0) {
        ++votes[static_cast<std::size_t>(r)];
      }
    }
    const auto most = std::max_element(votes.begin(), votes.begin() + static_cast<std::ptrdiff_t>(known_regions));
    const auto before = static_cast<std::size_t>(most - votes.begin());
    const bool was_part = known_regions > 0 && *most * 4 >= clusters[c].features && *most > 0;
    const bool continues = was_part && !regions_[before].moving;
    std::int16_t index = continues ? static_cast<std::int16_t>(before) : std::int16_t{-1};
    if (!continues && regions_.push_back({})) {
      index = static_cast<std::int16_t>(regions_.size() - 1);
      regions_.back().id = next_region_id_++;
      regions_.back().beside = was_part && clusters[c].split ? regions_[before].id : 0;
    }
    region_of_cluster_[c] = index;
    if (index < 0) {
      continue;
    }
    join_parts(static_cast<std::size_t>(index), votes, cluster_of_feature);
    MotionRegion& region = regions_[static_cast<std::size_t>(index)];
    if (!region.moving) {  // clusters are sorted by size
      region.moving = true;
      ++region.moving_frames;
      region.votes += std::clamp(clusters[c].features - 1, kMinVotes, kMaxVotes);
      region.velocity_mps = clusters[c].velocity_mps;
      region.covariance = clusters[c].covariance;
    }
  }
}

// Regions become parts of region `whole` if most of their features in clusters are in the one that continues it.
void MotionMemory::join_parts(std::size_t whole, const std::array<int, kMaxRegions>& votes,
                              std::span<const std::int16_t> cluster_of_feature) {
  for (std::size_t r = 0; r < regions_.size(); ++r) {
    const auto part = static_cast<std::int16_t>(r);
    if (r == whole || votes[r] < kMinHeldFeatures || regions_[r].moving) {
      continue;
    }
    int moving = 0;
    for (std::size_t i = 0; i < region_of_.size(); ++i) {
      moving += region_of_[i] == part && cluster_of_feature[i] >= 0 ? 1 : 0;
    }
    if (2 * votes[r] > moving) {
      std::replace(region_of_.begin(), region_of_.end(), part, static_cast<std::int16_t>(whole));
      (void)joined_.push_back({.part = regions_[r].id, .whole = regions_[whole].id});  // as many places as regions
    }
  }
}

bool MotionMemory::is_inconsistent(const FeatureMotion& motion, const MotionRegion& region) const {
  const float moving_chi2 = mahalanobis_sq(motion.velocity_mps - region.velocity_mps,
                                           motion.covariance + region.covariance + velocity_slack(region.velocity_mps));
  return moving_chi2 > kSameVelocityChi2 || moving_chi2 > motion.static_chi2 + kLeaveChi2;
}

// Members of clusters are assigned to their cluster's region. Others stay without contrary evidence: a feature that has
// moved with a region leaves when its motion contradicts the moving region (not a resting one: then the object has
// stopped); a feature merely found on the region's mask stays as long as the region shows no motion, but only for a
// short time.
void MotionMemory::add_known_features(std::span<const Feature> features, std::span<const FeatureMotion> motions,
                                      std::span<const std::int16_t> cluster_of_feature) {
  for (std::size_t i = 0; i < features.size(); ++i) {
    if (cluster_of_feature[i] >= 0) {
      region_of_[i] = region_of_cluster_[static_cast<std::size_t>(cluster_of_feature[i])];
      has_moved_with_region_[i] = region_of_[i] >= 0 ? 1 : 0;
    } else if (region_of_[i] >= 0) {
      const MotionRegion& region = regions_[static_cast<std::size_t>(region_of_[i])];
      const bool contradicted = motions[i].known && is_inconsistent(motions[i], region);
      DwellTime idle = region.idle;
      idle.add_frame(interval_ns_);
      const bool leaves = has_moved_with_region(i) ? region.moving && contradicted
                                                   : region.moving || contradicted || idle.exceeds(kMaxUnknown_ns);
      region_of_[i] = leaves ? std::int16_t{-1} : region_of_[i];
    }
    if (region_of_[i] >= 0) {
      ++regions_[static_cast<std::size_t>(region_of_[i])].features;
    }
  }
}

void MotionMemory::drop_stale() {
  const std::int64_t hold_ns = to_ns(config_.hold_s);
  std::array<std::int16_t, kMaxRegions> new_index{};
  std::size_t kept = 0;
  for (std::size_t r = 0; r < regions_.size(); ++r) {
    MotionRegion region = regions_[r];
    if (region.moving) {
      region.idle.reset();
    } else {
      region.idle.add_frame(interval_ns_);
    }
    const bool confirmed = region.moving_frames >= config_.confirm_frames && region.votes >= kConfirmVotes;
    const bool continues = confirmed
                               ? !region.idle.exceeds(hold_ns) && (region.moving || region.features >= kMinHeldFeatures)
                               : !region.idle.exceeds(kMaxUnconfirmedGap_ns);
    const bool alive = continues && whole_of(region.id) == region.id;
    region.reported = confirmed && alive;
    new_index[r] = alive ? static_cast<std::int16_t>(kept) : std::int16_t{-1};
    if (alive) {
      regions_[kept++] = region;
    }
  }
  regions_.resize(kept);
  for (std::int16_t& r : region_of_) {
    r = r < 0 ? r : new_index[static_cast<std::size_t>(r)];
  }
  for (std::int16_t& r : region_of_blob_) {
    r = r < 0 ? r : new_index[static_cast<std::size_t>(r)];
  }
}

}  // namespace kinetrace::segmentation

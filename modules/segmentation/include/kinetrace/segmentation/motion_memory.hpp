// Confirmation of moving regions, and their retention after they stop.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include <Eigen/Core>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/dwell_time.hpp"
#include "kinetrace/core/feature_frame.hpp"
#include "kinetrace/core/fixed_vector.hpp"
#include "kinetrace/segmentation/config.hpp"
#include "kinetrace/segmentation/motion_clusters.hpp"
#include "kinetrace/segmentation/motion_evidence.hpp"
#include "kinetrace/segmentation/moving_blobs.hpp"

namespace kinetrace::segmentation {

/// A cluster of features followed over frames by the features themselves. Internal to motion segmentation: it decides
/// on reporting, not on identities.
struct MotionRegion {
  std::uint32_t id = 0;
  Eigen::Vector3f velocity_mps{0.F, 0.F, 0.F};  ///< When it last moved.
  Eigen::Matrix3f covariance = Eigen::Matrix3f::Zero();
  int moving_frames = 0;
  int votes = 0;          ///< Features that agreed on its motion, summed over these frames.
  DwellTime idle;         ///< Without motion.
  bool moving = false;    ///< In this frame.
  bool reported = false;  ///< Confirmed, and moving or recently stopped.
  int features = 0;       ///< In this frame.
  /// Region of the vehicle beside it that drives alike, of which it was a part before; 0 = none.
  std::uint32_t beside = 0;
};

/// A region that became a part of another one.
struct JoinedRegion {
  std::uint32_t part = 0;
  std::uint32_t whole = 0;
};

/// A region is confirmed after `confirm_frames` frames of motion, or more if few features agreed on it, and retained by
/// its features for `hold_s` after the last one: an object that halts does not vanish at once. In each frame: begin,
/// update, sustain where due, conclude.
class MotionMemory {
 public:
  static constexpr std::size_t kMaxRegions = MotionClusters::kMaxClusters;

  MotionMemory() = default;
  MotionMemory(const MotionConfig& config, int max_features, Arena& arena);

  /// Recalls each feature's region. `interval_ns`: since the frame before. `inherited_region` (parallel to the
  /// features): id of the region on whose mask a feature without history was found, else 0. Tracking a new object
  /// replaces its features, so the old ones cannot carry a region on.
  void begin(std::int64_t interval_ns, std::span<const Feature> features,
             std::span<const std::uint32_t> inherited_region);
  /// Assigns each cluster to the region with most votes of its features, if these are at least a quarter of them and no
  /// larger cluster of this frame continues that region; otherwise to a new one. Another region becomes a part of it if
  /// most of its features in clusters are in this one. `drawn_region`: id of the region on
  /// whose mask each feature was, in the frame before; used for features that were in none.
  void update(std::span<const Feature> features, std::span<const FeatureMotion> motions,
              std::span<const MotionCluster> clusters, std::span<const std::int16_t> cluster_of_feature,
              std::span<const std::uint32_t> drawn_region);
  /// Continues regions by blobs, or initiates them. `drawn_as`: id of the region that a blob was drawn as in the frame
  /// before, 0 = none; `blob_of_feature`: index of the blob that a feature lies on, -1 = none.
  void update_blobs(std::span<const MovingBlob> blobs, std::span<const std::uint32_t> drawn_as,
                    std::span<const std::int16_t> blob_of_feature);
  /// Marks a region without a cluster in this frame as moving, by evidence of the images.
  void sustain(std::size_t region) noexcept;
  /// Drops regions without motion for too long.
  void conclude(std::span<const Feature> features, std::span<const FeatureMotion> motions);
  void reset() noexcept;

  [[nodiscard]] std::span<const MotionRegion> regions() const noexcept { return regions_.span(); }
  /// Those that became parts of others in this frame; no longer in regions().
  [[nodiscard]] std::span<const JoinedRegion> joined() const noexcept { return joined_.span(); }
  /// Index of each feature's region in regions(), -1 = none; parallel to the features of the last update.
  [[nodiscard]] std::span<const std::int16_t> region_of_feature() const noexcept { return region_of_.span(); }
  /// The same for the blobs of the last update.
  [[nodiscard]] std::span<const std::int16_t> region_of_blob() const noexcept { return region_of_blob_.span(); }
  /// True if a feature's own motion agreed with its region; parallel to the features as well.
  [[nodiscard]] bool has_moved_with_region(std::size_t feature) const noexcept {
    return has_moved_with_region_[feature] != 0;
  }

 private:
  struct Membership {
    std::uint32_t feature_id = 0;
    std::uint32_t region_id = 0;
    bool has_moved_with_region = false;
    DwellTime unknown;  ///< Since its own motion was last known.
  };

  void recall(std::span<const Feature> features, std::span<const std::uint32_t> inherited_region);
  /// The region of which it became a part in this frame, else itself.
  [[nodiscard]] std::uint32_t whole_of(std::uint32_t region_id) const noexcept;
  [[nodiscard]] std::int16_t index_of(std::uint32_t region_id) const noexcept;
  void assign_clusters(std::span<const MotionCluster> clusters, std::span<const std::int16_t> cluster_of_feature,
                       std::span<const std::uint32_t> drawn_region);
  void join_parts(std::size_t whole, const std::array<int, kMaxRegions>& votes,
                  std::span<const std::int16_t> cluster_of_feature);
  [[nodiscard]] std::int16_t region_of(std::size_t blob, std::uint32_t drawn_as,
                                       std::span<const std::int16_t> blob_of_feature) const;
  void add_known_features(std::span<const Feature> features, std::span<const FeatureMotion> motions,
                          std::span<const std::int16_t> cluster_of_feature);
  void drop_stale();
  void memorise(std::span<const Feature> features, std::span<const FeatureMotion> motions);
  [[nodiscard]] bool is_inconsistent(const FeatureMotion& motion, const MotionRegion& region) const;

  MotionConfig config_;
  std::int64_t interval_ns_ = 0;
  std::uint32_t next_region_id_ = 1;
  std::span<Membership> memory_;
  FixedVector<MotionRegion> regions_;
  FixedVector<JoinedRegion> joined_;
  FixedVector<std::int16_t> region_of_;
  FixedVector<std::int16_t> region_of_blob_;
  FixedVector<std::uint8_t> has_moved_with_region_;
  std::array<std::int16_t, MotionClusters::kMaxClusters> region_of_cluster_{};
};

}  // namespace kinetrace::segmentation

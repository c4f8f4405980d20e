// Groups of features that move together through the world.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include <Eigen/Core>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/feature_frame.hpp"
#include "kinetrace/core/fixed_vector.hpp"
#include "kinetrace/core/stereo_geometry.hpp"
#include "kinetrace/segmentation/config.hpp"
#include "kinetrace/segmentation/motion_evidence.hpp"

namespace kinetrace::segmentation {

/// One group.
struct MotionCluster {
  Eigen::Vector3f velocity_mps{0.F, 0.F, 0.F};
  Eigen::Matrix3f covariance = Eigen::Matrix3f::Zero();
  int features = 0;
  std::uint8_t body = 0;  ///< Label that most of its features carry.
};

/// Finds them in two steps. A feature moves when the pooled velocity of its neighbours (near in the image, at the same
/// depth, with a velocity like its own) differs from zero by `significance` standard deviations, systematic errors
/// included, and enough of the neighbours agree: single outliers find nobody to agree with, and slow objects are found
/// although none of their features is conclusive alone. Three features are enough where the speed is beyond all doubt:
/// small, fast objects have no more. Moving neighbours with the same velocity are joined
/// (union-find); groups that lie on one tracked body and move alike are joined whatever lies between them; features
/// that fit the group's motion better than rest are added.
class MotionClusters {
 public:
  static constexpr std::size_t kMaxClusters = 64;

  MotionClusters() = default;
  MotionClusters(const MotionConfig& config, const StereoGeometry& geometry, int max_features, Arena& arena);

  /// `motions` is parallel to `features`. The result lives until the next call, most features first.
  std::span<const MotionCluster> find(std::span<const Feature> features, std::span<const FeatureMotion> motions,
                                      double ego_speed_mps);

  /// Cluster of each feature of the last call, -1 = none.
  [[nodiscard]] std::span<const std::int16_t> cluster_of_feature() const noexcept { return cluster_of_.span(); }

 private:
  enum class Verdict : std::uint8_t { kStatic, kMoving, kClearlyMoving };
  struct Pooled {
    Verdict verdict = Verdict::kStatic;
    Eigen::Vector3f velocity_mps{0.F, 0.F, 0.F};
    Eigen::Matrix3f covariance = Eigen::Matrix3f::Zero();
  };

  void fill_grid();
  [[nodiscard]] std::size_t cell_index(int x, int y) const noexcept {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(grid_width_) + static_cast<std::size_t>(x);
  }
  void pool(std::size_t i);
  [[nodiscard]] Verdict assess(const Eigen::Vector3f& velocity_mps, const Eigen::Matrix3f& covariance) const;
  [[nodiscard]] bool moving(std::size_t i) const noexcept { return pooled_[i].verdict != Verdict::kStatic; }
  void join_neighbours();
  void collect();
  void join_bodies();
  void absorb();
  void summarise();
  /// Largest first; empty ones are dropped.
  void sort_by_size();
  template <typename Visit>
  void for_each_neighbour(std::size_t i, Visit&& visit) const;
  [[nodiscard]] float reach_px(std::size_t i) const noexcept;
  [[nodiscard]] bool same_depth(std::size_t i, std::size_t j) const noexcept;
  [[nodiscard]] std::uint16_t root(std::uint16_t i) noexcept;

  MotionConfig config_;
  StereoGeometry geometry_;
  float min_speed_mps_ = 0.F;
  int grid_width_ = 0;
  int grid_height_ = 0;
  std::span<const Feature> features_;
  std::span<const FeatureMotion> motions_;
  std::span<std::int16_t> cell_first_;
  std::span<std::int16_t> next_in_cell_;
  std::span<Pooled> pooled_;
  std::span<std::uint16_t> parent_;
  FixedVector<std::int16_t> cluster_of_;
  FixedVector<MotionCluster> clusters_;
};

}  // namespace kinetrace::segmentation

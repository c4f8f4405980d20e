// Clusters of features with a common motion in the world.
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
#include "kinetrace/segmentation/temporal_test.hpp"

namespace kinetrace::segmentation {

/// One group.
struct MotionCluster {
  Eigen::Vector3f velocity_mps{0.F, 0.F, 0.F};
  Eigen::Matrix3f covariance = Eigen::Matrix3f::Zero();
  int features = 0;
  std::uint8_t body = 0;  ///< Label of most of its features.
  bool split = false;     ///< One of two vehicles beside each other that were one cluster.
};

/// Clustering by hypotheses. A feature whose own velocity lies significantly outside the ball of slow velocities,
/// systematic errors included, is a seed. From seeds on, the most significant one first, a hypothesis grows over
/// neighbours (near in the image, at the same depth) whose motion it explains better than rest does, and updates its
/// velocity by theirs; features that fit both hypotheses are ignored. It does not grow across ground, a gap to farther
/// surfaces, a step of depth, or into another known region. It becomes a cluster with enough features, or with fewer if
/// the images around them agree (TemporalTest). A cluster wider across its motion than vehicles are is two, divided at
/// the widest gap. Clusters with similar motion are joined if they lie on one tracked body or fit into one van;
/// features that fit a cluster's motion better than rest are added. Features on the ground (shadows, reflections) or
/// higher than objects reach are excluded.
class MotionClusters {
 public:
  static constexpr std::size_t kMaxClusters = 64;

  MotionClusters() = default;
  MotionClusters(const MotionConfig& config, const StereoGeometry& geometry, int max_features, Arena& arena);

  /// `motions` and `known_region` are parallel to `features`; known_region: the region (any number) of a feature in the
  /// frame before, -1 = none. The result lives until the next call, most features first.
  std::span<const MotionCluster> find(std::span<const Feature> features, std::span<const FeatureMotion> motions,
                                      double ego_speed_mps, const DenseView& dense, const TemporalTest& test,
                                      std::span<const std::int16_t> known_region);

  /// Cluster of each feature of the last call, -1 = none.
  [[nodiscard]] std::span<const std::int16_t> cluster_of_feature() const noexcept { return cluster_of_.span(); }

 private:
  /// A motion, and its support.
  struct Hypothesis {
    std::size_t seed = 0;
    std::int16_t label = -1;
    std::int16_t region = -1;  ///< Known region of its features, -1 = none.
    Eigen::Matrix3f information = Eigen::Matrix3f::Zero();
    Eigen::Vector3f weighted{0.F, 0.F, 0.F};  ///< Sum of information times velocity.
    Eigen::Vector3f velocity_mps{0.F, 0.F, 0.F};
    Eigen::Matrix3f covariance = Eigen::Matrix3f::Zero();
    int agreeing = 0;            ///< Pairs of neighbours with the same motion.
    int at_rest_neighbours = 0;  ///< Neighbours of its features, on the same surface, at rest.
  };

  /// Axes on the ground, camera axes: along a motion and across it.
  struct MotionAxes {
    Eigen::Vector3f along{0.F, 0.F, 0.F};
    Eigen::Vector3f across{0.F, 0.F, 0.F};
    float angle_variance = 0.F;  ///< Of their direction, rad^2.
  };

  void fill_grid();
  [[nodiscard]] std::size_t cell_index(int x, int y) const noexcept {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(grid_width_) + static_cast<std::size_t>(x);
  }
  [[nodiscard]] bool separated(std::size_t i, std::size_t j) const noexcept;
  /// Axes of zero length where the ground is not known, or the velocity is vertical.
  [[nodiscard]] MotionAxes axes_of(const Eigen::Vector3f& velocity_mps, const Eigen::Matrix3f& covariance) const;
  /// True if two features are certainly farther apart across the motion than a vehicle is wide: they lie on two.
  [[nodiscard]] bool side_by_side(const MotionAxes& axes, std::size_t i, std::size_t j) const noexcept;
  [[nodiscard]] Eigen::Vector3f position_m(std::size_t i) const noexcept;
  [[nodiscard]] bool belong_together(std::int16_t a, std::int16_t b) const;
  void list_seeds();
  void grow_from(std::size_t seed);
  void test_neighbour(Hypothesis& h, std::size_t from, std::size_t j);
  [[nodiscard]] bool holds(const Hypothesis& h) const;
  void split_wide();
  void join_parts();
  void absorb();
  void summarise();
  /// Largest first; empty ones are dropped.
  void sort_by_size();
  template <typename Visit>
  void for_each_neighbour(std::size_t i, Visit&& visit) const;
  [[nodiscard]] float reach_px(std::size_t i) const noexcept;
  [[nodiscard]] bool same_depth(std::size_t i, std::size_t j) const noexcept;

  MotionConfig config_;
  StereoGeometry geometry_;
  float min_speed_mps_ = 0.F;
  int grid_width_ = 0;
  int grid_height_ = 0;
  std::span<const Feature> features_;
  std::span<const FeatureMotion> motions_;
  const DenseView* dense_ = nullptr;
  const TemporalTest* test_ = nullptr;
  std::span<const std::int16_t> known_region_;
  std::span<std::int16_t> cell_first_;
  std::span<std::int16_t> next_in_cell_;
  std::span<float> motion_chi2_;        ///< By feature: distance to the nearest velocity that counts as rest.
  std::span<std::uint8_t> excluded_;    ///< By feature: 1 if on the ground, or higher than objects reach.
  FixedVector<std::uint16_t> seeds_;    ///< Features whose own motion is significant, most significant first.
  FixedVector<std::uint16_t> support_;  ///< Features of the hypothesis being grown.
  FixedVector<std::int16_t> cluster_of_;
  FixedVector<MotionCluster> clusters_;
};

}  // namespace kinetrace::segmentation

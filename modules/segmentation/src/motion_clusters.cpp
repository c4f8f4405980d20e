#include "kinetrace/segmentation/motion_clusters.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <Eigen/LU>

#include "velocity_test.hpp"

namespace kinetrace::segmentation {
namespace {

constexpr int kCellPx = 32;
constexpr float kMinReachPx = 24.F;
constexpr float kMaxReachPx = 96.F;
/// Neighbours looked at per feature, from near to far cells: more add time, not knowledge.
constexpr int kMaxNeighbours = 24;
/// A feature whose own velocity is this close to rest needs no second look (3 degrees of freedom: 39 % of static ones
/// are looked at).
constexpr float kCandidateChi2 = 3.F;
/// Share of the neighbours at the same depth that must agree.
constexpr float kMinAgreement = 0.4F;
/// Depth over which one object extends.
constexpr float kObjectDepthM = 3.F;
/// Twice the significance and twice the smallest speed leave no doubt, and then this many features are enough.
constexpr float kClearFactor = 2.F;
constexpr int kMinClearFeatures = 3;
/// Standard deviations by which a speed must exceed the smallest one.
constexpr float kSpeedMarginSigmas = 2.F;
/// A feature joins a group when its motion is likelier by this much than rest (difference of chi-squares).
constexpr float kAbsorbChi2 = 4.F;

}  // namespace

MotionClusters::MotionClusters(const MotionConfig& config, const StereoGeometry& geometry, int max_features,
                               Arena& arena)
    : config_(config),
      geometry_(geometry),
      grid_width_(geometry.width_px / kCellPx + 1),
      grid_height_(geometry.height_px / kCellPx + 1) {
  const auto n = static_cast<std::size_t>(max_features);
  cell_first_ =
      arena.take<std::int16_t>(static_cast<std::size_t>(grid_width_) * static_cast<std::size_t>(grid_height_));
  next_in_cell_ = arena.take<std::int16_t>(n);
  pooled_ = arena.take<Pooled>(n);
  parent_ = arena.take<std::uint16_t>(n);
  cluster_of_ = FixedVector<std::int16_t>(arena, n);
  clusters_ = FixedVector<MotionCluster>(arena, kMaxClusters);
}

std::span<const MotionCluster> MotionClusters::find(std::span<const Feature> features,
                                                    std::span<const FeatureMotion> motions, double ego_speed_mps) {
  // What goes wrong with static features (sliding along an edge, a depth from the wrong match) grows with the camera's
  // own motion.
  min_speed_mps_ = static_cast<float>(std::max(config_.min_speed_mps, config_.min_speed_ratio * ego_speed_mps));
  features_ = features.first(motions.size());
  motions_ = motions;
  fill_grid();
  for (std::size_t i = 0; i < features_.size(); ++i) {
    pool(i);
  }
  join_neighbours();
  collect();
  summarise();
  join_bodies();
  summarise();
  absorb();
  summarise();
  return clusters_.span();
}

void MotionClusters::fill_grid() {
  std::fill(cell_first_.begin(), cell_first_.end(), std::int16_t{-1});
  for (std::size_t i = features_.size(); i-- > 0;) {
    if (!motions_[i].known) {
      continue;
    }
    const int x = std::clamp(static_cast<int>(features_[i].left_px.x()) / kCellPx, 0, grid_width_ - 1);
    const int y = std::clamp(static_cast<int>(features_[i].left_px.y()) / kCellPx, 0, grid_height_ - 1);
    std::int16_t& first = cell_first_[cell_index(x, y)];
    next_in_cell_[i] = first;
    first = static_cast<std::int16_t>(i);
  }
}

float MotionClusters::reach_px(std::size_t i) const noexcept {
  const auto link_px = static_cast<float>(geometry_.fx_px * config_.link_distance_m);
  return std::clamp(link_px / motions_[i].depth_m, kMinReachPx, kMaxReachPx);
}

bool MotionClusters::same_depth(std::size_t i, std::size_t j) const noexcept {
  const float di = features_[i].disparity_px();
  const float dj = features_[j].disparity_px();
  // delta d = d / z * delta z, plus three standard deviations of the difference of two disparities.
  const float tolerance = std::max(di, dj) * kObjectDepthM / std::max(motions_[i].depth_m, motions_[j].depth_m) +
                          6.F * static_cast<float>(config_.sigma_px);
  return std::abs(di - dj) <= tolerance;
}

/// Visits features other than `i` with a known motion, within reach and at the same depth, cell rings from near to far.
template <typename Visit>
void MotionClusters::for_each_neighbour(std::size_t i, Visit&& visit) const {
  const Eigen::Vector2f center = features_[i].left_px;
  const float reach = reach_px(i);
  const int cx = static_cast<int>(center.x()) / kCellPx;
  const int cy = static_cast<int>(center.y()) / kCellPx;
  const int rings = static_cast<int>(std::ceil(reach / kCellPx));
  int seen = 0;
  for (int ring = 0; ring <= rings && seen < kMaxNeighbours; ++ring) {
    for (int y = std::max(0, cy - ring); y <= std::min(grid_height_ - 1, cy + ring); ++y) {
      const bool edge_row = y == cy - ring || y == cy + ring;
      for (int x = cx - ring; x <= cx + ring; x += edge_row || ring == 0 ? 1 : 2 * ring) {
        if (x < 0 || x >= grid_width_) {
          continue;
        }
        for (int j = cell_first_[cell_index(x, y)]; j >= 0; j = next_in_cell_[static_cast<std::size_t>(j)]) {
          const auto other = static_cast<std::size_t>(j);
          if (other != i && (features_[other].left_px - center).squaredNorm() <= reach * reach &&
              same_depth(i, other)) {
            ++seen;
            visit(other);
          }
        }
      }
    }
  }
}

void MotionClusters::pool(std::size_t i) {
  Pooled& pooled = pooled_[i];
  pooled = {};
  const FeatureMotion& own = motions_[i];
  if (!own.known || own.static_chi2 < kCandidateChi2) {
    return;
  }
  const Eigen::Matrix3f own_covariance = own.covariance + velocity_slack(own.velocity_mps);
  // The feature's own velocity chose the neighbours; counting it as well would let its noise speak twice.
  Eigen::Matrix3f information = Eigen::Matrix3f::Zero();
  Eigen::Vector3f weighted = Eigen::Vector3f::Zero();
  int near = 1;
  int agreeing = 1;
  for_each_neighbour(i, [&](std::size_t j) {
    const FeatureMotion& other = motions_[j];
    ++near;
    if (mahalanobis_sq(other.velocity_mps - own.velocity_mps, own_covariance + other.covariance) < kSameVelocityChi2) {
      ++agreeing;
      information += other.information;
      weighted += other.information * other.velocity_mps;
    }
  });
  if (agreeing < kMinClearFeatures || static_cast<float>(agreeing) < kMinAgreement * static_cast<float>(near)) {
    return;
  }
  pooled.covariance = information.inverse();
  pooled.velocity_mps = pooled.covariance * weighted;
  const Verdict verdict = assess(pooled.velocity_mps, pooled.covariance + own.systematic);
  const bool enough = agreeing >= config_.min_features || verdict == Verdict::kClearlyMoving;
  pooled.verdict = enough ? verdict : Verdict::kStatic;
}

// Differs from rest significantly, and is faster than the limit beyond reasonable doubt.
MotionClusters::Verdict MotionClusters::assess(const Eigen::Vector3f& velocity_mps,
                                               const Eigen::Matrix3f& covariance) const {
  const float chi2 = mahalanobis_sq(velocity_mps, covariance);
  const auto min_chi2 = static_cast<float>(config_.significance * config_.significance);
  const float speed = velocity_mps.norm();
  const Eigen::Vector3f direction = velocity_mps / speed;
  const float surely_mps = speed - kSpeedMarginSigmas * std::sqrt(direction.dot(covariance * direction));
  if (!(chi2 >= min_chi2 && surely_mps >= min_speed_mps_)) {
    return Verdict::kStatic;
  }
  const bool clear = chi2 >= kClearFactor * kClearFactor * min_chi2 && surely_mps >= kClearFactor * min_speed_mps_;
  return clear ? Verdict::kClearlyMoving : Verdict::kMoving;
}

std::uint16_t MotionClusters::root(std::uint16_t i) noexcept {
  while (parent_[i] != i) {
    parent_[i] = parent_[parent_[i]];  // path halving
    i = parent_[i];
  }
  return i;
}

void MotionClusters::join_neighbours() {
  std::iota(parent_.begin(), parent_.end(), std::uint16_t{0});
  for (std::size_t i = 0; i < features_.size(); ++i) {
    if (!moving(i)) {
      continue;
    }
    for_each_neighbour(i, [&](std::size_t j) {
      if (!moving(j)) {
        return;
      }
      const Eigen::Vector3f difference = pooled_[i].velocity_mps - pooled_[j].velocity_mps;
      const Eigen::Matrix3f covariance =
          pooled_[i].covariance + pooled_[j].covariance + velocity_slack(pooled_[i].velocity_mps);
      if (mahalanobis_sq(difference, covariance) < kSameVelocityChi2) {
        const std::uint16_t a = root(static_cast<std::uint16_t>(i));
        const std::uint16_t b = root(static_cast<std::uint16_t>(j));
        parent_[std::max(a, b)] = std::min(a, b);
      }
    });
  }
}

// Trees of enough features become clusters; at kMaxClusters the rest is left out.
void MotionClusters::collect() {
  cluster_of_.clear();
  cluster_of_.resize(features_.size());
  std::fill(cluster_of_.begin(), cluster_of_.end(), std::int16_t{-1});
  clusters_.clear();
  for (std::size_t i = 0; i < features_.size(); ++i) {
    if (!moving(i) || root(static_cast<std::uint16_t>(i)) != i) {
      continue;
    }
    const auto member = [&](std::size_t j) { return moving(j) && root(static_cast<std::uint16_t>(j)) == i; };
    int count = 0;
    int clear = 0;
    for (std::size_t j = i; j < features_.size(); ++j) {  // a root is the smallest index of its tree
      count += member(j) ? 1 : 0;
      clear += member(j) && pooled_[j].verdict == Verdict::kClearlyMoving ? 1 : 0;
    }
    const bool enough = count >= config_.min_features || clear >= kMinClearFeatures;
    if (!enough || !clusters_.push_back({})) {
      continue;
    }
    for (std::size_t j = i; j < features_.size(); ++j) {
      cluster_of_[j] = member(j) ? static_cast<std::int16_t>(clusters_.size() - 1) : cluster_of_[j];
    }
  }
}

// Velocity, size and body of each cluster; drops empty ones and sorts by size.
void MotionClusters::summarise() {
  std::array<std::array<std::uint16_t, kMaxObjects + 1>, kMaxClusters> votes{};
  std::array<Eigen::Matrix3f, kMaxClusters> information;
  std::array<Eigen::Vector3f, kMaxClusters> weighted;
  information.fill(Eigen::Matrix3f::Zero());
  weighted.fill(Eigen::Vector3f::Zero());
  for (MotionCluster& cluster : clusters_) {
    cluster = {};
  }
  for (std::size_t i = 0; i < features_.size(); ++i) {
    if (cluster_of_[i] < 0) {
      continue;
    }
    const auto c = static_cast<std::size_t>(cluster_of_[i]);
    ++clusters_[c].features;
    information[c] += motions_[i].information;
    weighted[c] += motions_[i].information * motions_[i].velocity_mps;
    if (features_[i].body <= kMaxObjects) {
      ++votes[c][features_[i].body];
    }
  }
  for (std::size_t c = 0; c < clusters_.size(); ++c) {
    if (clusters_[c].features > 0) {
      clusters_[c].covariance = information[c].inverse();
      clusters_[c].velocity_mps = clusters_[c].covariance * weighted[c];
      clusters_[c].body =
          static_cast<std::uint8_t>(std::max_element(votes[c].begin(), votes[c].end()) - votes[c].begin());
    }
  }
  sort_by_size();
}

void MotionClusters::sort_by_size() {
  std::array<std::int16_t, kMaxClusters> order{};
  std::iota(order.begin(), order.end(), std::int16_t{0});
  const std::size_t total = clusters_.size();
  std::sort(order.begin(), order.begin() + total, [&](std::int16_t a, std::int16_t b) {
    const int features_a = clusters_[static_cast<std::size_t>(a)].features;
    const int features_b = clusters_[static_cast<std::size_t>(b)].features;
    return features_a != features_b ? features_a > features_b : a < b;
  });
  std::array<MotionCluster, kMaxClusters> sorted;
  std::array<std::int16_t, kMaxClusters> rank{};
  std::size_t kept = 0;
  for (std::size_t k = 0; k < total; ++k) {
    const auto c = static_cast<std::size_t>(order[k]);
    rank[c] = static_cast<std::int16_t>(k);
    sorted[k] = clusters_[c];
    kept += clusters_[c].features > 0 ? 1U : 0U;
  }
  clusters_.resize(kept);
  std::copy_n(sorted.begin(), kept, clusters_.begin());
  for (std::int16_t& c : cluster_of_) {
    c = c < 0 ? c : rank[static_cast<std::size_t>(c)];
  }
}

// Parts of one tracked object may be too far apart to link; its label says that they belong together.
void MotionClusters::join_bodies() {
  for (std::size_t a = 0; a < clusters_.size(); ++a) {
    for (std::size_t b = a + 1; b < clusters_.size(); ++b) {
      if (clusters_[a].body == kBackgroundLabel || clusters_[a].body != clusters_[b].body) {
        continue;
      }
      const Eigen::Matrix3f covariance =
          clusters_[a].covariance + clusters_[b].covariance + velocity_slack(clusters_[a].velocity_mps);
      if (mahalanobis_sq(clusters_[a].velocity_mps - clusters_[b].velocity_mps, covariance) < kSameVelocityChi2) {
        std::replace(cluster_of_.begin(), cluster_of_.end(), static_cast<std::int16_t>(b),
                     static_cast<std::int16_t>(a));
      }
    }
  }
}

void MotionClusters::absorb() {
  for (std::size_t i = 0; i < features_.size(); ++i) {
    if (cluster_of_[i] >= 0 || !motions_[i].known) {
      continue;
    }
    const FeatureMotion& own = motions_[i];
    std::int16_t best = -1;
    float best_chi2 = std::min(kSameVelocityChi2, own.static_chi2 - kAbsorbChi2);
    for_each_neighbour(i, [&](std::size_t j) {
      // Only members that moved by themselves draw others in, so that a group does not creep outwards.
      if (cluster_of_[j] < 0 || !moving(j)) {
        return;
      }
      const MotionCluster& cluster = clusters_[static_cast<std::size_t>(cluster_of_[j])];
      const float chi2 = mahalanobis_sq(own.velocity_mps - cluster.velocity_mps,
                                        own.covariance + cluster.covariance + velocity_slack(cluster.velocity_mps));
      if (chi2 < best_chi2) {
        best_chi2 = chi2;
        best = cluster_of_[j];
      }
    });
    cluster_of_[i] = best;
  }
}

}  // namespace kinetrace::segmentation

#include "kinetrace/segmentation/motion_clusters.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include <Eigen/LU>

#include "velocity_test.hpp"

namespace kinetrace::segmentation {
namespace {

constexpr int kBucketPx = 32;
constexpr float kMinReachPx = 24.F;
constexpr float kMaxReachPx = 96.F;
/// Neighbours per feature, from near to far cells: more add time, not information.
constexpr int kMaxNeighbours = 24;
/// Three standard deviations from rest, which one static feature in thirty reaches: enough for a hypothesis.
constexpr float kSeedChi2 = 9.F;
/// Largest extent of an object in depth.
constexpr float kObjectDepthM = 3.F;
/// Least ratio of agreeing pairs of neighbours to neighbours at rest: among mismatches, chance reaches one.
constexpr int kMinPurity = 2;
/// Least evidence of the images around a cluster with fewer features than required.
constexpr float kSupportNats = 3.F;
constexpr float kSupportRadiusM = 0.8F;
/// A feature joins a cluster if its motion fits better than rest by this much (difference of chi-squares).
constexpr float kAbsorbChi2 = 4.F;
/// Two features are separated by cells between them, so many in a row, that are farther away by this much.
constexpr float kGapDepthM = 1.F;
/// Or by a step in depth.
constexpr float kStepDepthM = 1.5F;
constexpr int kGapCells = 2;
/// Vehicles are at most this wide (Council Directive 96/53/EC).
constexpr float kMaxWidthM = 2.6F;
/// Parts of one vehicle that are not known to be one are no farther apart than a van is long.
constexpr float kMaxLengthM = 7.F;
/// Of the direction of a vehicle's motion from its axis, in a bend.
constexpr float kSlipSigmaRad = 0.1F;

}  // namespace

MotionClusters::MotionClusters(const MotionConfig& config, const StereoGeometry& geometry, int max_features,
                               Arena& arena)
    : config_(config),
      geometry_(geometry),
      grid_width_(geometry.width_px / kBucketPx + 1),
      grid_height_(geometry.height_px / kBucketPx + 1) {
  const auto n = static_cast<std::size_t>(max_features);
  cell_first_ =
      arena.take<std::int16_t>(static_cast<std::size_t>(grid_width_) * static_cast<std::size_t>(grid_height_));
  next_in_cell_ = arena.take<std::int16_t>(n);
  motion_chi2_ = arena.take<float>(n);
  excluded_ = arena.take<std::uint8_t>(n);
  seeds_ = FixedVector<std::uint16_t>(arena, n);
  support_ = FixedVector<std::uint16_t>(arena, n);
  cluster_of_ = FixedVector<std::int16_t>(arena, n);
  clusters_ = FixedVector<MotionCluster>(arena, kMaxClusters);
}

std::span<const MotionCluster> MotionClusters::find(std::span<const Feature> features,
                                                    std::span<const FeatureMotion> motions, double ego_speed_mps,
                                                    const DenseView& dense, const TemporalTest& test,
                                                    std::span<const std::int16_t> known_region) {
  dense_ = &dense;
  test_ = &test;
  known_region_ = known_region;
  // Errors of static features (sliding along an edge, a depth from a mismatch) grow with the camera's own motion.
  min_speed_mps_ = static_cast<float>(std::max(config_.min_speed_mps, config_.min_speed_ratio * ego_speed_mps));
  features_ = features.first(motions.size());
  motions_ = motions;
  fill_grid();
  list_seeds();
  for (const std::uint16_t seed : seeds_) {
    if (cluster_of_[seed] < 0) {
      grow_from(seed);
    }
  }
  summarise();
  split_wide();
  summarise();
  join_parts();
  summarise();
  absorb();
  summarise();
  return clusters_.span();
}

void MotionClusters::fill_grid() {
  std::fill(cell_first_.begin(), cell_first_.end(), std::int16_t{-1});
  for (std::size_t i = features_.size(); i-- > 0;) {
    if (!motions_[i].known && !motions_[i].fresh) {
      continue;
    }
    const int x = std::clamp(static_cast<int>(features_[i].left_px.x()) / kBucketPx, 0, grid_width_ - 1);
    const int y = std::clamp(static_cast<int>(features_[i].left_px.y()) / kBucketPx, 0, grid_height_ - 1);
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
  const int cx = static_cast<int>(center.x()) / kBucketPx;
  const int cy = static_cast<int>(center.y()) / kBucketPx;
  const int rings = static_cast<int>(std::ceil(reach / kBucketPx));
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

// True if a farther surface, or the ground, is visible between two features.
bool MotionClusters::separated(std::size_t i, std::size_t j) const noexcept {
  const ImageView<const float> cells = dense_->disparity.disparity_px();
  const Eigen::Vector2f a = features_[i].left_px / static_cast<float>(kCellPx);
  const Eigen::Vector2f b = features_[j].left_px / static_cast<float>(kCellPx);
  const auto fb = static_cast<float>(geometry_.fx_px * geometry_.baseline_m);
  const float farther_px = fb / (fb / std::min(features_[i].disparity_px(), features_[j].disparity_px()) + kGapDepthM) -
                           3.F * dense_->disparity.sigma_px();
  const int steps = static_cast<int>((b - a).cwiseAbs().maxCoeff());
  int gap = 0;
  float last = features_[i].disparity_px();
  for (int k = 1; k < steps; ++k) {
    const Eigen::Vector2f p = a + (b - a) * (static_cast<float>(k) / static_cast<float>(steps));
    const int cx = std::clamp(static_cast<int>(p.x()), 0, cells.width - 1);
    const int cy = std::clamp(static_cast<int>(p.y()), 0, cells.height - 1);
    const float d = cells.row(cy)[cx];
    const bool between = d >= 0.F && (d < farther_px || dense_->ground.object_nats(cell_center(cx), cell_center(cy), d,
                                                                                   dense_->disparity.sigma_px()) <
                                                            GroundPlane::kGroundNats);
    if (d > 0.F) {
      const float near_px = std::max(d, last);
      const float step = near_px - fb / (fb / near_px + kStepDepthM);
      if (std::abs(d - last) > step + 3.F * dense_->disparity.sigma_px()) {
        return true;
      }
      last = d;
    }
    gap = between ? gap + 1 : 0;
    if (gap >= kGapCells) {
      return true;
    }
  }
  return false;
}

MotionClusters::MotionAxes MotionClusters::axes_of(const Eigen::Vector3f& velocity_mps,
                                                   const Eigen::Matrix3f& covariance) const {
  constexpr float kMinSpeedMps = 1e-3F;
  MotionAxes axes;
  if (!dense_->ground.known() || dense_->history.size() == 0) {
    return axes;
  }
  const Eigen::Matrix3f R_cam_world = dense_->history.at(0).T_world_cam.rotation.transpose().cast<float>();
  const Eigen::Vector3f down = dense_->ground.normal();
  const Eigen::Vector3f velocity = R_cam_world * velocity_mps;
  const Eigen::Vector3f across = down.cross(velocity);
  const float speed = across.norm();
  if (speed > kMinSpeedMps) {
    axes.across = across / speed;
    axes.along = axes.across.cross(down);
    const Eigen::Vector3f in_world = R_cam_world.transpose() * axes.across;
    axes.angle_variance = in_world.dot(covariance * in_world) / (speed * speed) + kSlipSigmaRad * kSlipSigmaRad;
  }
  return axes;
}

Eigen::Vector3f MotionClusters::position_m(std::size_t i) const noexcept {
  return geometry_.triangulate(features_[i].left_px.x(), features_[i].v_px, features_[i].disparity_px()).cast<float>();
}

// Two vehicles beside each other may drive alike: the widest gap across their motion divides them.
void MotionClusters::split_wide() {
  for (std::size_t c = 0; c < clusters_.size(); ++c) {
    const MotionAxes axes = axes_of(clusters_[c].velocity_mps, clusters_[c].covariance);
    const auto across_m = [&](std::size_t i) { return axes.across.dot(position_m(i)); };
    support_.clear();
    for (std::size_t i = 0; i < features_.size(); ++i) {
      if (cluster_of_[i] == static_cast<std::int16_t>(c)) {
        (void)support_.push_back(static_cast<std::uint16_t>(i));  // as many places as features
      }
    }
    std::sort(support_.begin(), support_.end(), [&](std::uint16_t a, std::uint16_t b) {
      const float of_a = across_m(a);
      const float of_b = across_m(b);
      return of_a != of_b ? of_a < of_b : a < b;
    });
    if (support_.size() < 2 || !side_by_side(axes, support_[0], support_[support_.size() - 1])) {
      continue;
    }
    std::size_t second = 1;
    const auto gap_before = [&](std::size_t k) { return across_m(support_[k]) - across_m(support_[k - 1]); };
    for (std::size_t k = 2; k < support_.size(); ++k) {
      second = gap_before(k) > gap_before(second) ? k : second;
    }
    const auto few = static_cast<std::size_t>(config_.min_features);
    if (second < few || support_.size() - second < few) {
      continue;
    }
    if (!clusters_.push_back({})) {
      return;
    }
    for (std::size_t k = second; k < support_.size(); ++k) {
      cluster_of_[support_[k]] = static_cast<std::int16_t>(clusters_.size() - 1);
    }
    clusters_[c].split = true;
    clusters_.back() = clusters_[c];
  }
}

bool MotionClusters::side_by_side(const MotionAxes& axes, std::size_t i, std::size_t j) const noexcept {
  const Eigen::Vector3f a = position_m(i);
  const Eigen::Vector3f b = position_m(j);
  const auto fb = static_cast<float>(geometry_.fx_px * geometry_.baseline_m);
  const auto disparity_variance = static_cast<float>(2.0 * config_.sigma_px * config_.sigma_px);
  const float along_m = axes.along.dot(b - a);
  float variance = axes.angle_variance * along_m * along_m;
  for (const Eigen::Vector3f& p : {a, b}) {
    const float per_pixel_m = axes.across.dot(p) * p.z() / fb;
    variance += disparity_variance * per_pixel_m * per_pixel_m;
  }
  return std::abs(axes.across.dot(b - a)) > kMaxWidthM + 2.F * std::sqrt(variance);
}

// True if clusters `a` and `b` lie on one tracked body, or are no larger than a van together, and their two nearest
// features are not separated.
bool MotionClusters::belong_together(std::int16_t a, std::int16_t b) const {
  const std::uint8_t body = clusters_[static_cast<std::size_t>(a)].body;
  const bool one_body = body != kBackgroundLabel && body == clusters_[static_cast<std::size_t>(b)].body;
  const MotionCluster& first = clusters_[static_cast<std::size_t>(a)];
  const MotionAxes axes = axes_of(first.velocity_mps, first.covariance);
  float nearest_sq = std::numeric_limits<float>::max();
  std::size_t from = 0;
  std::size_t to = 0;
  for (std::size_t i = 0; i < features_.size(); ++i) {
    for (std::size_t j = 0; cluster_of_[i] == a && j < features_.size(); ++j) {
      if (cluster_of_[j] != b) {
        continue;
      }
      if (side_by_side(axes, i, j) || (!one_body && (position_m(j) - position_m(i)).norm() > kMaxLengthM)) {
        return false;
      }
      const float distance_sq = (features_[i].left_px - features_[j].left_px).squaredNorm();
      if (distance_sq < nearest_sq) {
        nearest_sq = distance_sq;
        from = i;
        to = j;
      }
    }
  }
  return !separated(from, to);
}

// A seed is a feature significantly faster than the limit by itself, systematic errors included.
void MotionClusters::list_seeds() {
  seeds_.clear();
  clusters_.clear();
  cluster_of_.clear();
  cluster_of_.resize(features_.size());
  std::fill(cluster_of_.begin(), cluster_of_.end(), std::int16_t{-1});
  for (std::size_t i = 0; i < features_.size(); ++i) {
    const FeatureMotion& m = motions_[i];
    motion_chi2_[i] = 0.F;
    // Excludes moving shadows and highlights on the ground.
    const Feature& f = features_[i];
    excluded_[i] = (m.known || m.fresh) && !dense_->ground.may_hold_object(f.left_px.x(), f.v_px, f.disparity_px(),
                                                                           dense_->disparity.sigma_px())
                       ? 1
                       : 0;
    if (!(m.known || m.fresh) || m.static_chi2 < kSeedChi2 || excluded_[i] != 0) {
      continue;
    }
    motion_chi2_[i] = distance_to_ball_sq(m.velocity_mps, m.covariance + m.systematic, min_speed_mps_);
    if (motion_chi2_[i] >= kSeedChi2) {
      (void)seeds_.push_back(static_cast<std::uint16_t>(i));
    }
  }
  std::sort(seeds_.begin(), seeds_.end(), [&](std::uint16_t a, std::uint16_t b) {
    return motion_chi2_[a] != motion_chi2_[b] ? motion_chi2_[a] > motion_chi2_[b] : a < b;
  });
}

void MotionClusters::grow_from(std::size_t seed) {
  Hypothesis h{.seed = seed,
               .label = static_cast<std::int16_t>(clusters_.size()),
               .region = known_region_[seed],
               .information = motions_[seed].information,
               .weighted = motions_[seed].information * motions_[seed].velocity_mps,
               .velocity_mps = motions_[seed].velocity_mps,
               .covariance = motions_[seed].covariance};
  support_.clear();
  (void)support_.push_back(static_cast<std::uint16_t>(seed));
  cluster_of_[seed] = h.label;
  for (std::size_t k = 0; k < support_.size(); ++k) {
    const std::size_t from = support_[k];
    for_each_neighbour(from, [&](std::size_t j) { test_neighbour(h, from, j); });
  }
  if (!holds(h) || !clusters_.push_back({})) {
    for (const std::uint16_t i : support_) {
      cluster_of_[i] = -1;
    }
  }
}

// Tests whether feature `j`, a neighbour of `from`, moves with the hypothesis, stands still, or fits both.
void MotionClusters::test_neighbour(Hypothesis& h, std::size_t from, std::size_t j) {
  if (cluster_of_[j] == h.label) {
    ++h.agreeing;
    return;
  }
  const bool in_other_region = h.region >= 0 && known_region_[j] >= 0 && known_region_[j] != h.region;
  if (cluster_of_[j] >= 0 || excluded_[j] != 0 || in_other_region) {
    return;
  }
  const FeatureMotion& other = motions_[j];
  const float chi2 = mahalanobis_sq(other.velocity_mps - h.velocity_mps,
                                    other.covariance + h.covariance + velocity_slack(h.velocity_mps));
  if (chi2 >= kSameVelocityChi2 || other.static_chi2 - chi2 < kAbsorbChi2) {
    h.at_rest_neighbours += other.known && other.static_chi2 < chi2 && !separated(from, j) ? 1 : 0;
    return;
  }
  if (separated(from, j)) {
    return;
  }
  ++h.agreeing;
  h.region = h.region >= 0 ? h.region : known_region_[j];
  cluster_of_[j] = h.label;
  (void)support_.push_back(static_cast<std::uint16_t>(j));  // as many places as features
  h.information += other.information;
  h.weighted += other.information * other.velocity_mps;
  h.covariance = h.information.inverse();
  h.velocity_mps = h.covariance * h.weighted;
}

// True if a hypothesis is significant and has enough support. Its features were selected by their own noise, so
// neighbours not selected count as well.
bool MotionClusters::holds(const Hypothesis& h) const {
  const float chi2 = distance_to_ball_sq(h.velocity_mps, h.covariance + motions_[h.seed].systematic, min_speed_mps_);
  if (chi2 < static_cast<float>(config_.significance * config_.significance)) {
    return false;
  }
  const auto known =
      std::count_if(support_.begin(), support_.end(), [&](std::uint16_t i) { return motions_[i].known; });
  if (known >= config_.min_features && h.agreeing >= kMinPurity * h.at_rest_neighbours) {
    return true;
  }
  const Feature& f = features_[h.seed];
  return test_->support_nats(*dense_, h.velocity_mps, f.left_px.x(), f.v_px, f.disparity_px(), kSupportRadiusM) >=
         kSupportNats;
}

// Computes velocity, size and body of each cluster; drops empty ones and sorts by size.
void MotionClusters::summarise() {
  std::array<std::array<std::uint16_t, kMaxObjects + 1>, kMaxClusters> votes{};
  std::array<Eigen::Matrix3f, kMaxClusters> information;
  std::array<Eigen::Vector3f, kMaxClusters> weighted;
  information.fill(Eigen::Matrix3f::Zero());
  weighted.fill(Eigen::Vector3f::Zero());
  for (MotionCluster& cluster : clusters_) {
    cluster = {.split = cluster.split};
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

// Joins parts of one tracked object that are too far apart for one hypothesis, by their common label.
void MotionClusters::join_parts() {
  for (std::size_t a = 0; a < clusters_.size(); ++a) {
    for (std::size_t b = a + 1; b < clusters_.size(); ++b) {
      const Eigen::Matrix3f covariance =
          clusters_[a].covariance + clusters_[b].covariance + velocity_slack(clusters_[a].velocity_mps);
      const bool alike =
          mahalanobis_sq(clusters_[a].velocity_mps - clusters_[b].velocity_mps, covariance) < kSameVelocityChi2;
      if (alike && clusters_[b].features > 0 &&
          belong_together(static_cast<std::int16_t>(a), static_cast<std::int16_t>(b))) {
        std::replace(cluster_of_.begin(), cluster_of_.end(), static_cast<std::int16_t>(b),
                     static_cast<std::int16_t>(a));
        clusters_[b].features = 0;
      }
    }
  }
}

void MotionClusters::absorb() {
  for (std::size_t i = 0; i < features_.size(); ++i) {
    if (cluster_of_[i] >= 0 || !motions_[i].known || excluded_[i] != 0) {
      continue;
    }
    const FeatureMotion& own = motions_[i];
    std::int16_t best = -1;
    float best_chi2 = std::min(kSameVelocityChi2, own.static_chi2 - kAbsorbChi2);
    for_each_neighbour(i, [&](std::size_t j) {
      // Members absorbed before in this pass count too: a cluster may grow by more than one neighbourhood.
      if (cluster_of_[j] < 0) {
        return;
      }
      const MotionCluster& cluster = clusters_[static_cast<std::size_t>(cluster_of_[j])];
      const float chi2 = mahalanobis_sq(own.velocity_mps - cluster.velocity_mps,
                                        own.covariance + cluster.covariance + velocity_slack(cluster.velocity_mps));
      if (chi2 < best_chi2 && !separated(i, j)) {
        best_chi2 = chi2;
        best = cluster_of_[j];
      }
    });
    cluster_of_[i] = best;
  }
}

}  // namespace kinetrace::segmentation

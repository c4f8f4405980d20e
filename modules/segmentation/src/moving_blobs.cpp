#include "kinetrace/segmentation/moving_blobs.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/LU>

#include "kinetrace/core/quantiles.hpp"
#include "velocity_test.hpp"

namespace kinetrace::segmentation {
namespace {

/// Grey difference of a changed cell: a multiple of the median at rest, plus an offset.
constexpr float kChangedRatio = 2.F;
constexpr float kChangedGrey = 1.F;
/// Least number of cells of a blob; largest number used for its velocity.
constexpr std::size_t kMinCells = 6;
constexpr std::size_t kMaxAsked = 64;
/// Gap of cells that is bridged, and largest difference in depth of neighbours.
constexpr int kBridgeCells = 2;
constexpr float kStepDepthM = 0.6F;
/// Search: walking speed at most, since faster objects are large and have features; step in pixels of the matching
/// images, within which patches still look alike.
constexpr float kMaxWalkMps = 3.F;
constexpr float kSearchStepPx = 1.5F;
constexpr int kMaxSearchSteps = 24;
constexpr std::size_t kSearchCells = 24;
constexpr int kRefinements = 4;
/// Standard deviation of a walking velocity, and of its variation within a second, m/s.
constexpr float kWalkMps = 3.F;
constexpr float kGaitMps = 0.5F;
/// Standard deviation of the vertical velocity on the ground.
constexpr float kClimbMps = 0.1F;
/// Least area of changed cells, square metres, and the largest speed of an object without features.
constexpr float kMinAreaM2 = 0.15F;
constexpr float kMaxBlobMps = 4.F;
/// A blob of this area whose cells have changed for this time is certain though its velocity varies, since a person
/// swings arms and legs; static parts with mismatches are small, short-lived, fit no velocity or no significant one.
constexpr float kSureAreaM2 = 0.3F;
constexpr float kSureS = 0.5F;
constexpr float kSureRatio = 0.9F;
constexpr float kSureSignificance = 3.F;
/// Frames that must agree on a velocity; largest part of the difference at rest that it may leave; mean NIS over its
/// expectation beyond which no single velocity fits.
constexpr int kMinFrames = 3;
constexpr float kExplainedRatio = 0.7F;
constexpr float kMaxNisRatio = 4.F;
/// Least log-likelihood ratio of an object above the ground, no higher than a truck.
constexpr float kStandsNats = 0.5F;

}  // namespace

Eigen::Matrix3f MovingBlob::covariance() const {
  return std::max(1.F, nis_ratio) * information.inverse();
}

MovingBlobs::MovingBlobs(const MotionConfig& config, const StereoGeometry& geometry, Arena& arena)
    : config_(config), geometry_(geometry) {
  const int width = (geometry.width_px + kCellPx - 1) / kCellPx;
  const int height = (geometry.height_px + kCellPx - 1) / kCellPx;
  const auto cells = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  scratch_ = arena.take<float>(cells);
  for (ImageView<float>& disparity : past_disparity_) {
    disparity = take_image<float>(arena, width, height);
  }
  residual_ = take_image<float>(arena, width, height);
  changed_ = take_image<float>(arena, width, height);
  owner_ = take_image<std::int16_t>(arena, width, height);
  owner_before_ = take_image<std::int16_t>(arena, width, height);
  cells_ = FixedVector<Cell>(arena, cells);
  blobs_ = FixedVector<MovingBlob>(arena, kMaxBlobs);
  blobs_before_ = FixedVector<MovingBlob>(arena, kMaxBlobs);
  if (!owner_.empty()) {  // a measuring arena has no memory
    reset();
  }
}

void MovingBlobs::reset() noexcept {
  blobs_.clear();
  for (int y = 0; y < owner_.height; ++y) {
    std::fill_n(owner_.row(y), owner_.width, std::int16_t{-1});
  }
}

void MovingBlobs::remember(ImageView<const float> disparity_px) {
  newest_ = (newest_ + 1) % past_disparity_.size();
  copy_image(disparity_px, past_disparity_[newest_]);
  std::swap(owner_, owner_before_);
  std::swap(blobs_, blobs_before_);
  reset();
}

std::span<const MovingBlob> MovingBlobs::find(const DenseView& dense, const TemporalTest& test, const Se3& T_world_cam,
                                              double ego_speed_mps) {
  remember(dense.disparity.disparity_px());
  lag_ = test.lag_after(kLookBackS);
  if (lag_ < 1) {
    return blobs_.span();
  }
  elapsed_s_ = test.elapsed_s(lag_);
  interval_s_ = test.elapsed_s(1);
  find_changed(dense, test);
  const Eigen::Vector3f down = T_world_cam.rotation.cast<float>() * dense.ground.normal();
  const Eigen::Vector3f across = T_world_cam.rotation.col(0).cast<float>();
  for (int cy = 0; cy < owner_.height; ++cy) {
    for (int cx = 0; cx < owner_.width; ++cx) {
      if (changed_.row(cy)[cx] < 0.F) {
        continue;
      }
      collect(cx, cy);
      if (cells_.size() < kMinCells) {
        continue;
      }
      MovingBlob blob;
      if (const MovingBlob* const known = previous_blob(test)) {
        blob = *known;
      } else {
        search(test, across, blob);
      }
      refine(test, down, blob);
      blob.moving = significant(blob, T_world_cam, ego_speed_mps);
      if (blobs_.push_back(blob)) {
        for (const Cell& c : cells_) {
          owner_.row(c.y)[c.x] = static_cast<std::int16_t>(blobs_.size() - 1);
        }
      }
    }
  }
  return blobs_.span();
}

void MovingBlobs::find_changed(const DenseView& dense, const TemporalTest& test) {
  const ImageView<const float> disparity = dense.disparity.disparity_px();
  const float sigma = dense.disparity.sigma_px();
  const auto least = static_cast<float>(config_.min_disparity_px);
  const PastPlaces at_rest = test.places_at_rest(lag_);
  std::size_t n = 0;
  for (int cy = 0; cy < disparity.height; ++cy) {
    for (int cx = 0; cx < disparity.width; ++cx) {
      const float d = disparity.row(cy)[cx];
      const bool candidate =
          d >= least && dense.ground.object_nats(cell_center(cx), cell_center(cy), d, sigma) > kStandsNats;
      residual_.row(cy)[cx] = candidate ? test.residual(at_rest, cx, cy, d) : -1.F;
      if (residual_.row(cy)[cx] >= 0.F) {
        scratch_[n++] = residual_.row(cy)[cx];
      }
    }
  }
  noise_ = n > 0 ? median(scratch_.first(n)) : 0.F;
  const float limit = kChangedRatio * noise_ + kChangedGrey;
  for (int cy = 0; cy < disparity.height; ++cy) {
    for (int cx = 0; cx < disparity.width; ++cx) {
      const float d = disparity.row(cy)[cx];
      changed_.row(cy)[cx] = -1.F;
      if (residual_.row(cy)[cx] < 0.F) {
        continue;
      }
      if (residual_.row(cy)[cx] <= limit || stands_elsewhere(dense, test, at_rest, cx, cy, limit)) {
        owner_.row(cy)[cx] = kStandsStill;
      } else if (!was_hidden(at_rest, cx, cy, d)) {
        changed_.row(cy)[cx] = d;
      }
    }
  }
}

// Fattening: a cell at the border of a near object has its disparity, but shows the background.
bool MovingBlobs::stands_elsewhere(const DenseView& dense, const TemporalTest& test, const PastPlaces& at_rest, int cx,
                                   int cy, float limit) const {
  const ImageView<const float> disparity = dense.disparity.disparity_px();
  const float d = disparity.row(cy)[cx];
  float least_px = d;
  float most_px = d;
  for (int y = std::max(0, cy - 2); y <= std::min(disparity.height - 1, cy + 2); ++y) {
    for (int x = std::max(0, cx - 2); x <= std::min(disparity.width - 1, cx + 2); ++x) {
      const float other = disparity.row(y)[x];
      least_px = other > 0.F ? std::min(least_px, other) : least_px;
      most_px = std::max(most_px, other);
    }
  }
  for (const float other : {least_px, most_px}) {
    const float r =
        std::abs(other - d) > 3.F * dense.disparity.sigma_px() ? test.residual(at_rest, cx, cy, other) : -1.F;
    if (r >= 0.F && r <= limit) {
      return true;
    }
  }
  return false;
}

// True if a nearer object occluded the cell's place at rest in the compared image.
bool MovingBlobs::was_hidden(const PastPlaces& at_rest, int cx, int cy, float disparity_px) const {
  const Eigen::Vector2f place = at_rest.at(cell_center(cx), cell_center(cy), disparity_px) / kCellPx;
  const ImageView<float>& then =
      past_disparity_[(newest_ + past_disparity_.size() - static_cast<std::size_t>(lag_)) % past_disparity_.size()];
  const float nearer =
      disparity_px * disparity_px * kStepDepthM * 2.F / static_cast<float>(geometry_.fx_px * geometry_.baseline_m) +
      static_cast<float>(matching_step(geometry_.width_px));
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      const int x = static_cast<int>(place.x()) + dx;
      const int y = static_cast<int>(place.y()) + dy;
      if (place.x() >= 1.F && place.y() >= 1.F && then.contains(x, y) && then.row(y)[x] > disparity_px + nearer) {
        return true;
      }
    }
  }
  return false;
}

// cells_ <- the blob around a changed cell; clears its cells from changed_.
void MovingBlobs::collect(int cx, int cy) {
  const auto fb = static_cast<float>(geometry_.fx_px * geometry_.baseline_m);
  const float noise = 0.6F * static_cast<float>(matching_step(geometry_.width_px));
  cells_.clear();
  const auto take = [&](int x, int y) {
    float& d = changed_.row(y)[x];
    (void)cells_.push_back({static_cast<std::int16_t>(x), static_cast<std::int16_t>(y), d});  // room for all cells
    d = -1.F;
  };
  take(cx, cy);
  for (std::size_t k = 0; k < cells_.size(); ++k) {
    const Cell from = cells_[k];
    const float step = from.disparity_px * from.disparity_px * kStepDepthM / fb + noise;
    for (int y = std::max(0, from.y - kBridgeCells); y <= std::min(owner_.height - 1, from.y + kBridgeCells); ++y) {
      for (int x = std::max(0, from.x - kBridgeCells); x <= std::min(owner_.width - 1, from.x + kBridgeCells); ++x) {
        const float d = changed_.row(y)[x];
        if (d > 0.F && std::abs(d - from.disparity_px) <= step) {
          take(x, y);
        }
      }
    }
  }
}

// The blob of the frame before that most of the cells belonged to, within two cells.
const MovingBlob* MovingBlobs::previous_blob(const TemporalTest& test) const {
  std::array<int, kMaxBlobs> votes{};
  const PastPlaces at_rest = test.places_at_rest(1);
  for (const Cell& c : cells_) {
    const Eigen::Vector2f place = at_rest.at(cell_center(c.x), cell_center(c.y), c.disparity_px) / kCellPx;
    for (const auto& [dx, dy] : {std::pair{0, 0}, {-2, 0}, {2, 0}, {0, -2}, {0, 2}}) {
      const int x = static_cast<int>(place.x()) + dx;
      const int y = static_cast<int>(place.y()) + dy;
      if (place.x() >= 2.F && place.y() >= 2.F && owner_before_.contains(x, y) && owner_before_.row(y)[x] >= 0) {
        ++votes[static_cast<std::size_t>(owner_before_.row(y)[x])];
        break;
      }
    }
  }
  const auto most = std::max_element(votes.begin(), votes.end());
  return 2 * static_cast<std::size_t>(*most) >= cells_.size()
             ? &blobs_before_[static_cast<std::size_t>(most - votes.begin())]
             : nullptr;
}

float MovingBlobs::mean_residual(const TemporalTest& test, const Eigen::Vector3f& velocity_mps,
                                 std::size_t samples) const {
  const std::size_t stride = std::max<std::size_t>(1, cells_.size() / samples);
  const PastPlaces places = test.places(velocity_mps, lag_);
  float total = 0.F;
  int seen = 0;
  int asked = 0;
  for (std::size_t k = 0; k < cells_.size(); k += stride) {
    const Cell& c = cells_[k];
    const float r = test.residual(places, c.x, c.y, c.disparity_px);
    total += r >= 0.F ? r : 0.F;
    seen += r >= 0.F ? 1 : 0;
    ++asked;
  }
  return 2 * seen >= asked ? total / static_cast<float>(seen) : 1e6F;
}

// Initial velocity for least squares, which converge only within the scale of the texture.
void MovingBlobs::search(const TemporalTest& test, const Eigen::Vector3f& across, MovingBlob& blob) const {
  const auto z = static_cast<float>(geometry_.depth_m(cells_[cells_.size() / 2].disparity_px));
  const float step_mps = kSearchStepPx * static_cast<float>(matching_step(geometry_.width_px)) * z /
                         static_cast<float>(geometry_.fx_px) / elapsed_s_;
  const int reach = std::min(kMaxSearchSteps, static_cast<int>(std::ceil(kMaxWalkMps / step_mps)));
  float best = mean_residual(test, Eigen::Vector3f::Zero(), kSearchCells);
  for (int k = -reach; k <= reach; ++k) {
    const Eigen::Vector3f v = static_cast<float>(k) * step_mps * across;
    const float r = mean_residual(test, v, kSearchCells);
    if (r < best) {
      best = r;
      blob.velocity_mps = v;
    }
  }
}

// Gauss-Newton on the grey differences of all pixels, and on the prior.
void MovingBlobs::refine(const TemporalTest& test, const Eigen::Vector3f& down, MovingBlob& blob) const {
  const bool known = blob.frames > 0;
  Eigen::Matrix3f prior = Eigen::Matrix3f::Identity() / (kWalkMps * kWalkMps);
  Eigen::Vector3f expected = Eigen::Vector3f::Zero();
  if (known) {
    const Eigen::Matrix3f spread =
        std::exp2(interval_s_ / static_cast<float>(config_.memory_s)) * blob.information.inverse() +
        interval_s_ * kGaitMps * kGaitMps * Eigen::Matrix3f::Identity();
    prior = spread.inverse();
    expected = blob.velocity_mps;
  }
  prior += down * down.transpose() / (kClimbMps * kClimbMps);
  const std::size_t stride = std::max<std::size_t>(1, cells_.size() / kMaxAsked);
  // Skipped cells are redundant; images compared in earlier frames are correlated.
  const float weight = static_cast<float>(stride) / static_cast<float>(lag_);
  const float noise = std::max(1.F, 2.F * noise_);
  Eigen::Matrix3f measured;
  for (int k = 0; k < kRefinements; ++k) {
    measured.setZero();
    Eigen::Vector3f weighted = Eigen::Vector3f::Zero();
    const PastPlaces places = test.places(blob.velocity_mps, lag_);
    for (std::size_t i = 0; i < cells_.size(); i += stride) {
      const Cell& c = cells_[i];
      test.add_equations(places, c.x, c.y, c.disparity_px, noise, measured, weighted);
    }
    measured *= weight;
    const Eigen::Vector3f pull = prior * (expected - blob.velocity_mps);
    blob.velocity_mps += (measured + prior).inverse() * (weight * weighted + pull);
  }
  blob.information = measured + prior;
  const float rest = mean_residual(test, Eigen::Vector3f::Zero(), kMaxAsked);
  const float moved = mean_residual(test, blob.velocity_mps, kMaxAsked);
  ++blob.frames;
  blob.seen_s += blob.frames > 1 ? interval_s_ : 0.F;
  blob.cells = static_cast<int>(cells_.size());
  const float fresh = std::max(0.1F, 1.F / static_cast<float>(blob.frames));
  blob.rest += fresh * (rest - blob.rest);
  blob.moved += fresh * (moved - blob.moved);
  if (known) {
    // d^T (P + M)^-1 d of the innovation d, computed from its correction.
    const Eigen::Vector3f correction = blob.velocity_mps - expected;
    const Eigen::Vector3f pulled = prior * correction;
    const float chi2 = pulled.dot(correction + (measured + 1e-3F * Eigen::Matrix3f::Identity()).inverse() * pulled);
    blob.nis_ratio += std::max(0.1F, 1.F / static_cast<float>(blob.frames)) * (chi2 / 3.F - blob.nis_ratio);
  }
}

Eigen::Matrix3f MovingBlobs::systematic_covariance(const MovingBlob& blob, const Se3& T_world_cam,
                                                   double ego_speed_mps) const {
  const Cell& middle = cells_[cells_.size() / 2];
  const double d = middle.disparity_px;
  const double z = geometry_.depth_m(d);
  const double x = (cell_center(middle.x) - geometry_.cx_px) / geometry_.fx_px;
  const double y = (cell_center(middle.y) - geometry_.cy_px) / geometry_.fy_px;
  // An error of the ego motion shifts the blob without changing its size. A bias of the disparity scales the effect of
  // the ego motion.
  const double seen_s =
      std::max<double>(elapsed_s_, std::min(static_cast<double>(blob.frames) * interval_s_, config_.memory_s));
  const double lateral = config_.ego_sigma_px * z / geometry_.fx_px / seen_s;
  const double radial = config_.bias_disparity_px / d * ego_speed_mps;
  const Eigen::Vector3d ray = T_world_cam.rotation * Eigen::Vector3d(x, y, 1.0);
  return apparent_velocity_covariance(ray, radial, lateral);
}

bool MovingBlobs::significant(const MovingBlob& blob, const Se3& T_world_cam, double ego_speed_mps) const {
  const auto min_speed = static_cast<float>(std::max(config_.min_speed_mps, config_.min_speed_ratio * ego_speed_mps));
  const float chi2 = distance_to_ball_sq(
      blob.velocity_mps, blob.covariance() + systematic_covariance(blob, T_world_cam, ego_speed_mps), min_speed);
  const float metres_per_cell =
      kCellPx * static_cast<float>(geometry_.baseline_m) / cells_[cells_.size() / 2].disparity_px;
  const float area_m2 = static_cast<float>(blob.cells) * metres_per_cell * metres_per_cell;
  if (area_m2 >= kSureAreaM2 && blob.seen_s >= kSureS && blob.moved < kSureRatio * blob.rest &&
      chi2 >= kSureSignificance * kSureSignificance) {
    return true;
  }
  return area_m2 >= kMinAreaM2 && blob.velocity_mps.norm() <= kMaxBlobMps && blob.frames >= kMinFrames &&
         blob.nis_ratio <= kMaxNisRatio && blob.moved < kExplainedRatio * blob.rest &&
         chi2 >= static_cast<float>(config_.significance * config_.significance);
}

}  // namespace kinetrace::segmentation

#include "kinetrace/segmentation/region_mask.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "velocity_test.hpp"

namespace kinetrace::segmentation {
namespace {

/// Reach of an object beyond its known parts, in all directions and in depth.
constexpr float kReachM = 1.2F;
constexpr float kMinReachPx = 12.F;
constexpr float kDepthReachM = 0.8F;
/// Disparity noise of a cell, in pixels of the matching images.
constexpr float kDisparityNoisePx = 0.6F;
/// Variance of velocities within one object, (m/s)^2.
constexpr float kVelocityVariance = 0.1F;

/// Prior: about a third of the cells within reach belong to the object.
constexpr float kPriorNats = -0.8F;
constexpr float kOwnDepthNats = 0.7F;
constexpr float kForeignDepthNats = -4.F;
/// Weight of the previous frame's ratio, and its bound.
constexpr float kMemory = 0.6F;
constexpr float kMaxPosteriorNats = 4.F;
constexpr float kSureNats = 1.F;
constexpr float kAboveGroundNats = 0.5F;
constexpr float kFeatureNats = 3.F;
constexpr float kBlobNats = 0.5F;
constexpr float kStillNats = -2.F;
constexpr float kNearNats = 0.F;
constexpr float kNatsPerMetre = 4.F;
constexpr float kFarNats = -1.F;

/// Edge-aware filter: reach in cells, and the step of grey, or of disparity over noise, equivalent to one cell.
constexpr float kSmoothingCells = 3.F;
constexpr float kGreyStep = 8.F;
constexpr float kDisparityStep = 0.5F;

float mean_grey(GrayView image, int cx, int cy, int pitch) {
  int total = 0;
  int count = 0;
  for (int y = cy * pitch; y < std::min((cy + 1) * pitch, image.height); ++y) {
    for (int x = cx * pitch; x < std::min((cx + 1) * pitch, image.width); ++x) {
      total += image.row(y)[x];
      ++count;
    }
  }
  return static_cast<float>(total) / static_cast<float>(std::max(count, 1));
}

}  // namespace

RegionMask::RegionMask(const StereoGeometry& geometry, int max_features, int max_objects, int min_area_px, Arena& arena)
    : geometry_(geometry), min_area_px_(min_area_px) {
  const auto n = static_cast<std::size_t>(max_features);
  const int width = (geometry.width_px + kCellPx - 1) / kCellPx;
  const int height = (geometry.height_px + kCellPx - 1) / kCellPx;
  labels_ = take_image<std::uint8_t>(arena, geometry.width_px, geometry.height_px);
  detections_ = FixedVector<Detection>(arena, static_cast<std::size_t>(max_objects));
  disparities_px_ = FixedVector<float>(arena, static_cast<std::size_t>(max_objects));
  candidates_ = FixedVector<Candidate>(arena, MotionMemory::kMaxRegions);
  drawn_ = FixedVector<Candidate>(arena, MotionMemory::kMaxRegions);
  inherited_ = FixedVector<std::uint32_t>(arena, n);
  drawn_region_ = FixedVector<std::uint32_t>(arena, n);
  drawn_as_ = FixedVector<std::uint32_t>(arena, MovingBlobs::kMaxBlobs);
  scratch_ = arena.take<float>(n + static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  previous_ = take_image<std::uint32_t>(arena, width, height);
  owner_ = take_image<std::int16_t>(arena, width, height);
  best_ = take_image<float>(arena, width, height);
  evidence_ = take_image<float>(arena, width, height);
  posterior_ = take_image<float>(arena, width, height);
  distance_ = take_image<float>(arena, width, height);
  grey_ = take_image<float>(arena, width, height);
  weight_right_ = take_image<float>(arena, width, height);
  weight_down_ = take_image<float>(arena, width, height);
  first_column_ = arena.take<float>(static_cast<std::size_t>(height));
  last_column_ = arena.take<float>(static_cast<std::size_t>(height));
  stack_ = arena.take<std::uint32_t>(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
}

void RegionMask::reset() noexcept {
  drawn_.clear();
  for (int y = 0; y < previous_.height; ++y) {
    std::fill_n(previous_.row(y), previous_.width, 0U);
  }
}

int RegionMask::draw(std::span<const Feature> features, std::span<const FeatureMotion> motions, MotionMemory& memory,
                     const DenseView& dense, const TemporalTest& test, ImageView<const std::int16_t> blob_of_cell) {
  blob_of_cell_ = blob_of_cell;
  const std::span<const Feature> known = features.first(motions.size());
  for (int y = 0; y < owner_.height; ++y) {
    std::fill_n(owner_.row(y), owner_.width, kFree);
    std::fill_n(best_.row(y), best_.width, 0.F);
  }
  candidates_.clear();
  join_cells(memory.joined());
  for (std::size_t r = 0; r < memory.regions().size(); ++r) {
    const MotionRegion& region = memory.regions()[r];
    if (region.reported && region.beside != 0 && drawn(region.id) == nullptr) {
      take_over_cells(r, known, memory);
    }
  }
  for (std::size_t r = 0; r < memory.regions().size(); ++r) {
    Candidate candidate;
    if (memory.regions()[r].reported && describe(r, known, memory, dense, test, candidate)) {
      weigh_cells(candidate, known, motions, memory, r, dense, test);
      diffuse(candidate, dense);
      assign_cells(candidate, candidates_.size());
      (void)candidates_.push_back(candidate);  // as many places as regions
    }
  }
  if (dense.history.size() > 0 && !dense.history.at(0).image.empty()) {
    complete_vehicles(known, dense);
  }
  write_labels();
  std::swap(drawn_, candidates_);
  const std::size_t found = drawn_.size();
  return static_cast<int>(found - std::min(found, detections_.size()));
}

bool RegionMask::is_member(int cx, int cy, std::size_t region, const MotionMemory& memory) const noexcept {
  const std::int16_t blob = blob_of_cell_.row(cy)[cx];
  return blob >= 0 && memory.region_of_blob()[static_cast<std::size_t>(blob)] == static_cast<std::int16_t>(region);
}

bool RegionMask::is_beside(const MotionMemory& memory, std::int16_t other, std::size_t region) {
  if (other < 0) {
    return false;
  }
  const MotionRegion& a = memory.regions()[static_cast<std::size_t>(other)];
  const MotionRegion& b = memory.regions()[region];
  return a.reported && (a.beside == b.id || b.beside == a.id);
}

bool RegionMask::describe(std::size_t region, std::span<const Feature> features, const MotionMemory& memory,
                          const DenseView& dense, const TemporalTest& test, Candidate& candidate) {
  const MotionRegion& r = memory.regions()[region];
  candidate.region_id = r.id;
  candidate.moving = r.moving;
  candidate.velocity_mps = r.moving ? r.velocity_mps : Eigen::Vector3f::Zero();
  candidate.covariance = r.covariance;
  std::size_t n = 0;
  PixelBox box;
  for (std::size_t i = 0; i < features.size(); ++i) {
    if (memory.region_of_feature()[i] == static_cast<std::int16_t>(region) && features[i].has_right()) {
      scratch_[n++] = features[i].disparity_px();
      box.include(static_cast<int>(features[i].left_px.x()) / kCellPx,
                  static_cast<int>(features[i].left_px.y()) / kCellPx);
    }
  }
  for (int y = 0; y < blob_of_cell_.height; ++y) {
    for (int x = 0; x < blob_of_cell_.width; ++x) {
      if (is_member(x, y, region, memory)) {
        scratch_[n++] = dense.disparity.disparity_px().row(y)[x];
        box.include(x, y);
        candidate.has_blob = true;
      }
    }
  }
  const Candidate* const before = drawn(r.id);
  const float fb = static_cast<float>(geometry_.fx_px * geometry_.baseline_m);
  const float noise = kDisparityNoisePx * static_cast<float>(matching_step(geometry_.width_px));
  if (n > 0) {
    std::sort(scratch_.begin(), scratch_.begin() + static_cast<std::ptrdiff_t>(n));
    candidate.disparity_px = scratch_[n / 2];
    candidate.far_px = fb / (fb / std::max(scratch_[n / 10], 0.5F) + kDepthReachM) - noise;
    candidate.near_px = fb / std::max(fb / scratch_[n - 1 - n / 10] - kDepthReachM, 0.2F) + noise;
  } else if (before != nullptr) {
    candidate.disparity_px = before->disparity_px;
    candidate.far_px = before->far_px;
    candidate.near_px = before->near_px;
  } else {
    return false;
  }
  for (int y = 0; y < previous_.height && before != nullptr; ++y) {
    for (int x = 0; x < previous_.width; ++x) {
      if (previous_.row(y)[x] == r.id) {
        box.include(x, y);
      }
    }
  }
  const float reach_px =
      std::max(kMinReachPx, kReachM * candidate.disparity_px / static_cast<float>(geometry_.baseline_m));
  const int reach = static_cast<int>(std::ceil(reach_px / kCellPx));
  candidate.cells = {std::max(0, box.x0 - reach), std::max(0, box.y0 - reach),
                     std::min(previous_.width, box.x1 + reach), std::min(previous_.height, box.y1 + reach)};
  candidate.lag = test.discriminating_lag(candidate.velocity_mps, cell_center((box.x0 + box.x1) / 2),
                                          cell_center((box.y0 + box.y1) / 2), candidate.disparity_px);
  return true;
}

// Cells of a blob are evidence for it, static cells beside them against it.
void RegionMask::weigh_blobs(const Candidate& candidate, const MotionMemory& memory, std::size_t region) {
  const PixelBox& box = candidate.cells;
  for (int cy = box.y0; cy < box.y1; ++cy) {
    for (int cx = box.x0; cx < box.x1; ++cx) {
      if (is_member(cx, cy, region, memory)) {
        evidence_.row(cy)[cx] += kBlobNats;
        distance_.row(cy)[cx] = 0.F;
      } else if (candidate.has_blob && blob_of_cell_.row(cy)[cx] == MovingBlobs::kStandsStill) {
        evidence_.row(cy)[cx] += kStillNats;
      }
    }
  }
}

void RegionMask::weigh_cells(const Candidate& candidate, std::span<const Feature> features,
                             std::span<const FeatureMotion> motions, const MotionMemory& memory, std::size_t region,
                             const DenseView& dense, const TemporalTest& test) {
  const PixelBox& box = candidate.cells;
  constexpr float kFar = 1e6F;
  for (int cy = box.y0; cy < box.y1; ++cy) {
    std::fill(evidence_.row(cy) + box.x0, evidence_.row(cy) + box.x1, kPriorNats);
    std::fill(distance_.row(cy) + box.x0, distance_.row(cy) + box.x1, kFar);
  }
  for (std::size_t i = 0; i < features.size(); ++i) {
    const int cx = static_cast<int>(features[i].left_px.x()) / kCellPx;
    const int cy = static_cast<int>(features[i].left_px.y()) / kCellPx;
    if (cx < box.x0 || cx >= box.x1 || cy < box.y0 || cy >= box.y1) {
      continue;
    }
    if (memory.region_of_feature()[i] == static_cast<std::int16_t>(region)) {
      evidence_.row(cy)[cx] += kFeatureNats;
      distance_.row(cy)[cx] = 0.F;
    } else if (is_beside(memory, memory.region_of_feature()[i], region)) {
      evidence_.row(cy)[cx] -= kFeatureNats;
    } else if (motions[i].known && candidate.moving) {
      const Eigen::Matrix3f covariance =
          motions[i].covariance + candidate.covariance + kVelocityVariance * Eigen::Matrix3f::Identity();
      if (mahalanobis_sq(motions[i].velocity_mps - candidate.velocity_mps, covariance) > kSameVelocityChi2) {
        evidence_.row(cy)[cx] -= kFeatureNats;
      }
    }
  }
  weigh_blobs(candidate, memory, region);
  const float metres_per_cell = kCellPx * static_cast<float>(geometry_.baseline_m) / candidate.disparity_px;
  weigh_memory(candidate, dense, test);
  measure_distances(box);
  const float sigma_px = dense.disparity.sigma_px();
  const ImageView<const float> disparity = dense.disparity.disparity_px();
  const TemporalTest::Hypotheses hypotheses = test.hypotheses(candidate.velocity_mps, candidate.lag);
  for (int cy = box.y0; cy < box.y1; ++cy) {
    for (int cx = box.x0; cx < box.x1; ++cx) {
      float& nats = evidence_.row(cy)[cx];
      const float d = disparity.row(cy)[cx];
      const float u = cell_center(cx);
      const float v = cell_center(cy);
      nats += std::max(kFarNats, kNearNats - kNatsPerMetre * metres_per_cell * distance_.row(cy)[cx]);
      if (d >= 0.F && (d < candidate.far_px || d > candidate.near_px)) {
        nats += kForeignDepthNats;
        continue;
      }
      const float assumed = d >= 0.F ? d : candidate.disparity_px;
      nats += d >= 0.F ? kOwnDepthNats : 0.F;
      const float above_ground = dense.ground.object_nats(u, v, assumed, sigma_px);
      nats += std::min(above_ground, d >= 0.F ? kAboveGroundNats : 0.F);
      nats += test.cell_nats(hypotheses, cx, cy, assumed);
    }
  }
}

// Adds the ratio of the previous frame at the cell's place then, if it moved with the candidate.
void RegionMask::weigh_memory(const Candidate& candidate, const DenseView& dense, const TemporalTest& test) {
  const PixelBox& box = candidate.cells;
  const PastPlaces places = test.places(candidate.velocity_mps, 1);
  for (int cy = box.y0; cy < box.y1 && dense.history.size() > 1; ++cy) {
    for (int cx = box.x0; cx < box.x1; ++cx) {
      const Eigen::Vector2f from = places.at(cell_center(cx), cell_center(cy), candidate.disparity_px);
      const int px = static_cast<int>(from.x()) / kCellPx;
      const int py = static_cast<int>(from.y()) / kCellPx;
      if (!(from.x() >= 0.F && from.y() >= 0.F && previous_.contains(px, py)) || previous_.row(py)[px] == 0) {
        continue;
      }
      const bool own = previous_.row(py)[px] == candidate.region_id;
      const float remembered = kMemory * std::min(posterior_.row(py)[px], kMaxPosteriorNats);
      evidence_.row(cy)[cx] += own ? remembered : -remembered;
      if (own && posterior_.row(py)[px] > kSureNats) {
        distance_.row(cy)[cx] = 0.F;
      }
    }
  }
}

// Distance to the nearest cell of distance 0, by a two-pass chamfer transform.
void RegionMask::measure_distances(const PixelBox& box) {
  constexpr float kDiagonal = 1.4142F;
  const auto relax = [&](int cx, int cy, int dx, int dy, float step) {
    const int x = cx + dx;
    const int y = cy + dy;
    if (x >= box.x0 && x < box.x1 && y >= box.y0 && y < box.y1) {
      float& d = distance_.row(cy)[cx];
      d = std::min(d, distance_.row(y)[x] + step);
    }
  };
  for (int cy = box.y0; cy < box.y1; ++cy) {
    for (int cx = box.x0; cx < box.x1; ++cx) {
      relax(cx, cy, -1, 0, 1.F);
      relax(cx, cy, -1, -1, kDiagonal);
      relax(cx, cy, 0, -1, 1.F);
      relax(cx, cy, 1, -1, kDiagonal);
    }
  }
  for (int cy = box.y1; cy-- > box.y0;) {
    for (int cx = box.x1; cx-- > box.x0;) {
      relax(cx, cy, 1, 0, 1.F);
      relax(cx, cy, 1, 1, kDiagonal);
      relax(cx, cy, 0, 1, 1.F);
      relax(cx, cy, -1, 1, kDiagonal);
    }
  }
}

void RegionMask::diffuse(const Candidate& candidate, const DenseView& dense) {
  const PixelBox& box = candidate.cells;
  const GrayView now = dense.history.size() > 0 ? dense.history.at(0).image : GrayView{};
  if (now.empty()) {
    return;
  }
  const int pitch = kCellPx / matching_step(geometry_.width_px);
  for (int cy = box.y0; cy < box.y1; ++cy) {
    for (int cx = box.x0; cx < box.x1; ++cx) {
      grey_.row(cy)[cx] = mean_grey(now, cx, cy, pitch);
    }
  }
  const float noise = kDisparityStep * static_cast<float>(matching_step(geometry_.width_px));
  const ImageView<const float> disparity = dense.disparity.disparity_px();
  const auto weight = [&](int ax, int ay, int bx, int by) {
    const float a = disparity.row(ay)[ax];
    const float b = disparity.row(by)[bx];
    const float step = a >= 0.F && b >= 0.F ? std::max(0.F, std::abs(a - b) - noise) / noise : 0.F;
    const float length = 1.F + std::abs(grey_.row(ay)[ax] - grey_.row(by)[bx]) / kGreyStep + step;
    return std::exp(-1.4142F / kSmoothingCells * length);
  };
  for (int cy = box.y0; cy < box.y1; ++cy) {
    for (int cx = box.x0; cx < box.x1; ++cx) {
      weight_right_.row(cy)[cx] = cx + 1 < box.x1 ? weight(cx, cy, cx + 1, cy) : 0.F;
      weight_down_.row(cy)[cx] = cy + 1 < box.y1 ? weight(cx, cy, cx, cy + 1) : 0.F;
    }
  }
  for (int round = 0; round < 2; ++round) {
    for (int cy = box.y0; cy < box.y1; ++cy) {
      float* const e = evidence_.row(cy);
      const float* const w = weight_right_.row(cy);
      for (int cx = box.x0 + 1; cx < box.x1; ++cx) {
        e[cx] += w[cx - 1] * (e[cx - 1] - e[cx]);
      }
      for (int cx = box.x1 - 1; cx-- > box.x0;) {
        e[cx] += w[cx] * (e[cx + 1] - e[cx]);
      }
    }
    const auto take_from = [&](int cy, const float* other, const float* w) {
      float* const e = evidence_.row(cy);
      for (int cx = box.x0; cx < box.x1; ++cx) {
        e[cx] += w[cx] * (other[cx] - e[cx]);
      }
    };
    for (int cy = box.y0 + 1; cy < box.y1; ++cy) {
      take_from(cy, evidence_.row(cy - 1), weight_down_.row(cy - 1));
    }
    for (int cy = box.y1 - 1; cy-- > box.y0;) {
      take_from(cy, evidence_.row(cy + 1), weight_down_.row(cy));
    }
  }
}

// Assigns cells with positive evidence that are connected to a member or to the previous mask.
void RegionMask::assign_cells(const Candidate& candidate, std::size_t index) {
  const PixelBox& box = candidate.cells;
  std::size_t top = 0;
  const auto offer = [&](int cx, int cy) {
    if (cx < box.x0 || cx >= box.x1 || cy < box.y0 || cy >= box.y1) {
      return;
    }
    const float e = evidence_.row(cy)[cx];
    if (e > best_.row(cy)[cx] && owner_.row(cy)[cx] != static_cast<std::int16_t>(index)) {
      best_.row(cy)[cx] = e;
      owner_.row(cy)[cx] = static_cast<std::int16_t>(index);
      stack_[top++] = static_cast<std::uint32_t>(cy * owner_.width + cx);
    }
  };
  for (int cy = box.y0; cy < box.y1; ++cy) {
    for (int cx = box.x0; cx < box.x1; ++cx) {
      if (distance_.row(cy)[cx] == 0.F) {
        offer(cx, cy);
      }
      while (top > 0) {
        const auto cell = static_cast<int>(stack_[--top]);
        const int x = cell % owner_.width;
        const int y = cell / owner_.width;
        offer(x - 1, y);
        offer(x + 1, y);
        offer(x, y - 1);
        offer(x, y + 1);
      }
    }
  }
}

void RegionMask::write_labels() {
  // Labels by size, largest first.
  std::array<int, MotionMemory::kMaxRegions> cells{};
  for (int y = 0; y < owner_.height; ++y) {
    for (int x = 0; x < owner_.width; ++x) {
      if (owner_.row(y)[x] >= 0) {
        ++cells[static_cast<std::size_t>(owner_.row(y)[x] % kCompleted)];
      }
    }
  }
  std::array<std::uint8_t, MotionMemory::kMaxRegions> order{};
  for (std::size_t k = 0; k < candidates_.size(); ++k) {
    order[k] = static_cast<std::uint8_t>(k);
  }
  std::sort(order.begin(), order.begin() + candidates_.size(),
            [&](std::uint8_t a, std::uint8_t b) { return cells[a] != cells[b] ? cells[a] > cells[b] : a < b; });
  std::array<std::uint8_t, MotionMemory::kMaxRegions> label_of{};
  region_of_label_.fill(0);
  detections_.clear();
  disparities_px_.clear();
  for (std::size_t k = 0; k < candidates_.size(); ++k) {
    const std::uint8_t c = order[k];
    if (cells[c] * kCellPx * kCellPx < min_area_px_ || detections_.full()) {
      continue;
    }
    Detection detection;
    detection.label = static_cast<std::uint8_t>(detections_.size() + 1);
    label_of[c] = detection.label;
    detection.moving = candidates_[c].moving;
    region_of_label_[detection.label] = candidates_[c].region_id;
    (void)detections_.push_back(detection);
    (void)disparities_px_.push_back(candidates_[c].disparity_px);  // as many places
  }
  for (int y = 0; y < owner_.height; ++y) {
    std::uint8_t* const row = labels_.row(y * kCellPx);
    const int rows = std::min(kCellPx, labels_.height - y * kCellPx);
    std::fill_n(row, labels_.width, kBackgroundLabel);
    for (int x = 0; x < owner_.width; ++x) {
      const std::int16_t o = owner_.row(y)[x];
      const std::uint8_t label = o < 0 ? kBackgroundLabel : label_of[static_cast<std::size_t>(o % kCompleted)];
      posterior_.row(y)[x] = best_.row(y)[x];
      previous_.row(y)[x] = label == kBackgroundLabel || o >= kCompleted ? 0U : region_of_label_[label];
      if (label != kBackgroundLabel) {
        const int x0 = x * kCellPx;
        const int x1 = std::min(x0 + kCellPx, labels_.width);
        std::fill(row + x0, row + x1, label);
        Detection& detection = detections_[label - 1U];
        detection.area_px += (x1 - x0) * rows;
        detection.box_px.include(x0, y * kCellPx);
        detection.box_px.include(x1 - 1, y * kCellPx + rows - 1);
      }
    }
    for (int v = 1; v < rows; ++v) {
      std::copy_n(row, labels_.width, labels_.row(y * kCellPx + v));
    }
  }
}

}  // namespace kinetrace::segmentation

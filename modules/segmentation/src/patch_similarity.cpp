#include "patch_similarity.hpp"

#include <algorithm>
#include <cmath>

namespace kinetrace::segmentation {
namespace {

constexpr int kHalfPx = 5;
constexpr int kSearchPx = 2;
constexpr int kPixels = (2 * kHalfPx + 1) * (2 * kHalfPx + 1);

float correlation(GrayView image, int ax, int ay, int bx, int by) noexcept {
  int sum_a = 0;
  int sum_b = 0;
  int sum_aa = 0;
  int sum_bb = 0;
  int sum_ab = 0;
  for (int y = -kHalfPx; y <= kHalfPx; ++y) {
    const std::uint8_t* a = image.row(ay + y) + ax - kHalfPx;
    const std::uint8_t* b = image.row(by + y) + bx - kHalfPx;
    for (int x = 0; x <= 2 * kHalfPx; ++x) {
      sum_a += a[x];
      sum_b += b[x];
      sum_aa += a[x] * a[x];
      sum_bb += b[x] * b[x];
      sum_ab += a[x] * b[x];
    }
  }
  const auto n = static_cast<float>(kPixels);
  const float variance_a = static_cast<float>(sum_aa) - static_cast<float>(sum_a) * static_cast<float>(sum_a) / n;
  const float variance_b = static_cast<float>(sum_bb) - static_cast<float>(sum_b) * static_cast<float>(sum_b) / n;
  const float covariance = static_cast<float>(sum_ab) - static_cast<float>(sum_a) * static_cast<float>(sum_b) / n;
  // A standard deviation below one gray level is noise.
  return variance_a < n || variance_b < n ? -1.F : covariance / std::sqrt(variance_a * variance_b);
}

}  // namespace

float patch_similarity(GrayView image, const Eigen::Vector2f& a, const Eigen::Vector2f& b) noexcept {
  const auto inside = [&](const Eigen::Vector2f& p, int reach) {
    const auto margin = static_cast<float>(reach + 1);
    return p.x() >= margin && p.y() >= margin && p.x() <= static_cast<float>(image.width - 1) - margin &&
           p.y() <= static_cast<float>(image.height - 1) - margin;
  };
  if (!inside(a, kHalfPx) || !inside(b, kHalfPx + kSearchPx)) {
    return -1.F;
  }
  const int ax = static_cast<int>(std::lround(a.x()));
  const int ay = static_cast<int>(std::lround(a.y()));
  const int bx = static_cast<int>(std::lround(b.x()));
  const int by = static_cast<int>(std::lround(b.y()));
  float best = -1.F;
  for (int dy = -kSearchPx; dy <= kSearchPx; ++dy) {
    for (int dx = -kSearchPx; dx <= kSearchPx; ++dx) {
      best = std::max(best, correlation(image, ax, ay, bx + dx, by + dy));
    }
  }
  return best;
}

}  // namespace kinetrace::segmentation

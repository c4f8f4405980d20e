#include "monitoring/patch_matcher.hpp"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <optional>

namespace kinetrace::hal {
namespace {

// All in pixels of the halved images.
constexpr int kPatchWidth = 16;
constexpr int kPatchHeight = 8;
constexpr int kMaxRows = kMaxRowShift_px / 2;
constexpr int kMaxDisparity = kMaxDisparity_px / 2;
constexpr double kFullSize = 2.0;

void halve(GrayView source, MutableGrayView target) noexcept {
  for (int y = 0; y < target.height; ++y) {
    const std::uint8_t* upper = source.row(2 * y);
    const std::uint8_t* lower = source.row(2 * y + 1);
    std::uint8_t* out = target.row(y);
    for (int x = 0; x < target.width; ++x, upper += 2, lower += 2) {
      out[x] = static_cast<std::uint8_t>((upper[0] + upper[1] + lower[0] + lower[1] + 2) / 4);
    }
  }
}

// Removes the local mean of each row: views of different gain compare.
void flatten(MutableGrayView image) noexcept {
  constexpr int kRadius = 8;
  constexpr int kGrey = 128;
  std::array<std::uint8_t, 2 * kRadius + 1> ring{};  // Original pixels of the window.
  for (int y = 0; y < image.height; ++y) {
    std::uint8_t* row = image.row(y);
    const int last = image.width - 1;
    int sum = 0;
    int first = -kRadius;
    for (std::uint8_t& pixel : ring) {
      pixel = row[std::clamp(first++, 0, last)];
      sum += pixel;
    }
    std::size_t oldest = 0;
    for (int x = 0; x < image.width; ++x) {
      const int detail = row[x] - sum / (2 * kRadius + 1);
      const std::uint8_t entering = row[std::min(x + kRadius + 1, last)];
      sum += entering - ring[oldest];
      ring[oldest] = entering;
      oldest = (oldest + 1) % ring.size();
      row[x] = static_cast<std::uint8_t>(std::clamp(kGrey + detail, 0, 255));
    }
  }
}

// Sum of absolute differences of two patches, given by their upper left pixels.
int difference(GrayView a, int ax, int ay, GrayView b, int bx, int by) noexcept {
  int sum = 0;
  for (int y = 0; y < kPatchHeight; ++y) {
    const std::uint8_t* pa = a.row(ay + y) + ax;
    const std::uint8_t* pb = b.row(by + y) + bx;
    for (int x = 0; x < kPatchWidth; ++x) {
      sum += std::abs(pa[x] - pb[x]);
    }
  }
  return sum;
}

// Texture of a patch along columns and rows.
int texture(GrayView image, int x0, int y0) noexcept {
  int across = 0;
  int down = 0;
  for (int y = 0; y < kPatchHeight - 1; ++y) {
    const std::uint8_t* row = image.row(y0 + y) + x0;
    const std::uint8_t* next = image.row(y0 + y + 1) + x0;
    for (int x = 0; x < kPatchWidth - 1; ++x) {
      across += std::abs(row[x + 1] - row[x]);
      down += std::abs(next[x] - row[x]);
    }
  }
  return std::min(across, down);
}

struct Patch {
  int x = 0;
  int y = 0;
};

// The patch of a cell with most texture; none if the cell is blank.
std::optional<Patch> choose(GrayView image, int column, int row) noexcept {
  constexpr int kStep = 8;
  constexpr int kMinTexture = 4 * (kPatchWidth - 1) * (kPatchHeight - 1);
  const int width = image.width - kPatchWidth;
  const int height = image.height - kPatchHeight - 2 * kMaxRows;
  std::optional<Patch> best;
  int most = kMinTexture;
  for (int y = row * height / PatchMatches::kRowsOfCells; y < (row + 1) * height / PatchMatches::kRowsOfCells;
       y += kStep) {
    for (int x = column * width / PatchMatches::kColumnsOfCells;
         x < (column + 1) * width / PatchMatches::kColumnsOfCells; x += kStep) {
      const int found = texture(image, x, y + kMaxRows);
      if (found > most) {
        most = found;
        best = Patch{x, y + kMaxRows};
      }
    }
  }
  return best;
}

// Offset of the minimum of a parabola through three adjacent costs from the middle one.
double sub_step(int before, int at, int after) noexcept {
  const int curvature = before - 2 * at + after;
  return curvature > 0 ? 0.5 * (before - after) / curvature : 0.0;
}

struct Searched {
  int first = 0;
  int last = 0;
};

std::optional<PatchMatch> match(GrayView left, GrayView right, const Patch& patch, const Searched& range) noexcept {
  constexpr int kWorstPerPixel = 12;
  constexpr int kWorst = kWorstPerPixel * kPatchWidth * kPatchHeight;
  constexpr int kNeighbourhood = 2;
  std::array<int, 2 * kMaxDisparity + 1> least{};
  const int first = std::max(range.first, patch.x + kPatchWidth - right.width);
  const int last = std::min(range.last, patch.x);
  int best = std::numeric_limits<int>::max();
  int best_disparity = 0;
  int best_row = 0;
  for (int disparity = first; disparity <= last; ++disparity) {
    int& here = least[static_cast<std::size_t>(disparity - first)];
    here = std::numeric_limits<int>::max();
    for (int row = -kMaxRows; row <= kMaxRows; ++row) {
      const int cost = difference(left, patch.x, patch.y, right, patch.x - disparity, patch.y + row);
      here = std::min(here, cost);
      if (cost < best) {
        best = cost;
        best_disparity = disparity;
        best_row = row;
      }
    }
  }
  if (best > kWorst || std::abs(best_row) == kMaxRows) {
    return std::nullopt;
  }
  for (int disparity = first; disparity <= last; ++disparity) {
    const bool is_elsewhere = std::abs(disparity - best_disparity) > kNeighbourhood;
    // The best cost must be a fifth below all others outside its neighbourhood.
    if (is_elsewhere && 5 * best > 4 * least[static_cast<std::size_t>(disparity - first)]) {
      return std::nullopt;
    }
  }
  const auto cost_at = [&](int disparity, int row) {
    return difference(left, patch.x, patch.y, right, patch.x - disparity, patch.y + row);
  };
  const double row =
      best_row + sub_step(cost_at(best_disparity, best_row - 1), best, cost_at(best_disparity, best_row + 1));
  const bool at_end = best_disparity == first || best_disparity == last;
  const double disparity =
      best_disparity +
      (at_end ? 0.0 : sub_step(cost_at(best_disparity - 1, best_row), best, cost_at(best_disparity + 1, best_row)));
  return PatchMatch{.row_px = kFullSize * row, .disparity_px = kFullSize * disparity};
}

}  // namespace

void prepare_patches(GrayView source, MutableGrayView target) noexcept {
  halve(source, target);
  flatten(target);
}

PatchMatches match_patches(GrayView left, GrayView right, const DisparityRange& range) noexcept {
  PatchMatches matches;
  if (left.width <= kPatchWidth || left.height <= kPatchHeight + 2 * kMaxRows) {
    return matches;
  }
  const Searched searched{std::max(range.first_px / 2, -kMaxDisparity), std::min(range.last_px / 2, kMaxDisparity)};
  for (int row = 0; row < PatchMatches::kRowsOfCells; ++row) {
    for (int column = 0; column < PatchMatches::kColumnsOfCells; ++column) {
      const std::optional<Patch> patch = choose(left, column, row);
      matches.searched += patch ? 1 : 0;
      if (const auto found = patch ? match(left, right, *patch, searched) : std::nullopt) {
        matches.found[matches.count++] = *found;
      }
    }
  }
  return matches;
}

}  // namespace kinetrace::hal

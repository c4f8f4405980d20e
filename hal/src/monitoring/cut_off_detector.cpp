#include "kinetrace/hal/cut_off_detector.hpp"

#include <algorithm>

namespace kinetrace::hal {
namespace {

constexpr int kMinMissingRows = 2;
constexpr int kAlwaysMissingShare = 3;  // As a divisor of the height.
constexpr int kMinContrast = 12;        // Several times the noise of a saturated or black row.

// Visits a few pixels, spread over a row.
template <typename Visit>
void sample_row(GrayView image, int y, Visit visit) noexcept {
  constexpr int kSampledPixels = 16;
  const std::uint8_t* row = image.row(y);
  const int step = std::max(1, image.width / kSampledPixels);
  for (int x = 0; x < image.width; x += step) {
    visit(row[x]);
  }
}

bool has_contrast(GrayView image, int y) noexcept {
  int lowest = 255;
  int highest = 0;
  sample_row(image, y, [&](int value) {
    lowest = std::min(lowest, value);
    highest = std::max(highest, value);
  });
  return highest - lowest >= kMinContrast;
}

// Number of rows at the bottom with one single value.
int flat_rows(GrayView image) noexcept {
  const std::uint8_t filling = image.row(image.height - 1)[image.width - 1];
  int rows = 0;
  while (rows < image.height) {
    const std::uint8_t* row = image.row(image.height - 1 - rows);
    if (std::any_of(row, row + image.width, [filling](std::uint8_t value) { return value != filling; })) {
      break;
    }
    ++rows;
  }
  return rows;
}

// Number of rows in which `other` has contrast, among the `rows` at the bottom without the last `usual` ones.
int seen_rows(GrayView other, int rows, int usual) noexcept {
  int seen = 0;
  for (int row = usual; row < rows; ++row) {
    seen += has_contrast(other, other.height - 1 - row) ? 1 : 0;
  }
  return seen;
}

// Whether most pixels above the `rows` at the bottom have another value. Skips one row in between, which may be
// incomplete.
bool has_sharp_edge(GrayView image, int rows) noexcept {
  const int above = image.height - 1 - rows - 1;
  if (above < 0) {
    return false;
  }
  const std::uint8_t filling = image.row(image.height - 1)[image.width - 1];
  int pixels = 0;
  int others = 0;
  sample_row(image, above, [&](std::uint8_t value) {
    ++pixels;
    others += value != filling ? 1 : 0;
  });
  return 2 * others > pixels;
}

}  // namespace

std::optional<CutOffDetector::Finding> CutOffDetector::examine(const StereoFrame& frame) noexcept {
  std::optional<Finding> finding;
  for (const bool is_left : {true, false}) {
    const GrayView image = is_left ? frame.left : frame.right;
    const GrayView other = is_left ? frame.right : frame.left;
    const int flat = flat_rows(image);
    std::optional<int>& usual = usual_rows_[is_left ? 0 : 1];
    const bool is_unusual = usual && flat - *usual >= kMinMissingRows && has_sharp_edge(image, flat) &&
                            seen_rows(other, flat, *usual) >= kMinMissingRows;
    usual = std::min(usual.value_or(flat), flat);
    if (is_unusual || (flat >= image.height / kAlwaysMissingShare &&
                       seen_rows(other, flat, 0) >= image.height / kAlwaysMissingShare)) {
      finding = Finding{is_left, flat};
    }
  }
  return finding;
}

}  // namespace kinetrace::hal

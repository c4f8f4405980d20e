#include "kinetrace/hal/sync_monitor.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <optional>

#include "kinetrace/core/config_check.hpp"

namespace kinetrace::hal {
namespace {

// All in pixels of the halved images.
constexpr int kPatchWidth = 16;
constexpr int kPatchHeight = 8;
constexpr int kMaxRows = 6;
constexpr int kColumnsOfCells = 8;
constexpr int kRowsOfCells = SyncMonitor::kPoints / kColumnsOfCells;
constexpr int kMaxDisparity = 256;
constexpr double kFullSize = 2.0;

constexpr int kFewestMatches = 8;
// In pixels of the full images: the median of good matches is .1 px, .3 px at the most.
constexpr double kSurelyOff_px = 0.25;
constexpr double kMuchBetter = 0.5;
// Over skipped frames: rows by which the image must move from frame to frame, and how many frames off is off.
constexpr int kMaxApart = 3;
constexpr double kMuchMotion_px = 0.75;
constexpr double kMostlyOff = 0.6;

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

// Leaves each row's detail and takes its brightness away, so that eyes with different gain compare.
void flatten(MutableGrayView image) noexcept {
  constexpr int kRadius = 8;
  constexpr int kGrey = 128;
  std::array<std::uint8_t, 2 * kRadius + 1> ring{};  // Pixels of the window as they were.
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

// Sum of absolute differences of two patches given by their upper left pixels.
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

// How well a patch tells both columns and rows apart.
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

// The best textured patch of a cell; none if the cell is blank.
std::optional<Patch> choose(GrayView image, int column, int row) noexcept {
  constexpr int kStep = 8;
  constexpr int kLeastTexture = 4 * (kPatchWidth - 1) * (kPatchHeight - 1);
  const int width = image.width - kPatchWidth;
  const int height = image.height - kPatchHeight - 2 * kMaxRows;
  std::optional<Patch> best;
  int most = kLeastTexture;
  for (int y = row * height / kRowsOfCells; y < (row + 1) * height / kRowsOfCells; y += kStep) {
    for (int x = column * width / kColumnsOfCells; x < (column + 1) * width / kColumnsOfCells; x += kStep) {
      const int found = texture(image, x, y + kMaxRows);
      if (found > most) {
        most = found;
        best = Patch{x, y + kMaxRows};
      }
    }
  }
  return best;
}

// The minimum of a parabola through three costs one step apart, as a shift of the middle one.
double sub_step(int before, int at, int after) noexcept {
  const int curvature = before - 2 * at + after;
  return curvature > 0 ? 0.5 * (before - after) / curvature : 0.0;
}

// How many rows lower the patch's match lies in the right image; none if no place is clearly the best.
std::optional<double> row_shift(GrayView left, GrayView right, const Patch& patch, int max_disparity) noexcept {
  constexpr int kWorstPerPixel = 12;
  constexpr int kWorst = kWorstPerPixel * kPatchWidth * kPatchHeight;
  constexpr int kNeighbourhood = 2;
  std::array<int, kMaxDisparity + 1> least{};
  const int last = std::min(max_disparity, patch.x);
  int best = std::numeric_limits<int>::max();
  int best_disparity = 0;
  int best_row = 0;
  for (int disparity = 0; disparity <= last; ++disparity) {
    int& here = least[static_cast<std::size_t>(disparity)];
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
  for (int disparity = 0; disparity <= last; ++disparity) {
    const bool is_elsewhere = std::abs(disparity - best_disparity) > kNeighbourhood;
    // A fifth better than anything elsewhere.
    if (is_elsewhere && 5 * best > 4 * least[static_cast<std::size_t>(disparity)]) {
      return std::nullopt;
    }
  }
  const auto cost_at = [&](int row) {
    return difference(left, patch.x, patch.y, right, patch.x - best_disparity, patch.y + row);
  };
  return best_row + sub_step(cost_at(best_row - 1), best, cost_at(best_row + 1));
}

double median(std::span<double> values) noexcept {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

Status SyncMonitorConfig::validate() const {
  return first_failure({check_range("sync.interval_frames", interval_frames, 2, 1000),
                        check_range("sync.max_disparity_px", max_disparity_px, 16, 2 * kMaxDisparity)});
}

void SyncMonitor::carve(int width_px, int height_px, Arena& arena, Storage& storage) {
  for (auto* pair : {&storage.now, &storage.before}) {
    for (MutableGrayView& image : *pair) {
      image = take_image<std::uint8_t>(arena, width_px / 2, height_px / 2);
    }
  }
}

std::size_t SyncMonitor::required_bytes(const SyncMonitorConfig& /*config*/, int width_px, int height_px) {
  return measure_bytes([&](Arena& arena) {
    Storage storage;
    carve(width_px, height_px, arena, storage);
  });
}

Result<SyncMonitor> SyncMonitor::create(const SyncMonitorConfig& config, int width_px, int height_px, Arena& arena) {
  if (const Status valid = config.validate(); !valid) {
    return Unexpected(valid.error());
  }
  Storage storage;
  carve(width_px, height_px, arena, storage);
  if (arena.exhausted()) {
    return fail(ErrorCode::kCapacity, "the arena does not hold the sync monitor; enlarge the memory budget");
  }
  return SyncMonitor(config, storage);
}

bool SyncMonitor::process(const RectifiedPair& pair) noexcept {
  const std::int64_t place = pairs_++ % config_.interval_frames;
  const bool is_before = place == config_.interval_frames - 2;
  const bool is_now = place == config_.interval_frames - 1;
  if (!is_before && !is_now) {
    return false;
  }
  const auto& target = is_before ? storage_.before : storage_.now;
  halve(pair.left, target[0]);
  halve(pair.right, target[1]);
  flatten(target[0]);
  flatten(target[1]);
  if (is_before) {
    before_index_ = pair.frame_index;
    return false;
  }
  const Residual same = measure(storage_.now[0], storage_.now[1]);
  ++report_.measurements;
  report_.matches = same.matches;
  report_.residual_px = same.median_px;
  report_.signed_residual_px = same.signed_px;
  report_.frames_apart = static_cast<int>(std::min<std::int64_t>(pair.frame_index - before_index_, kMaxApart + 1));
  if (report_.frames_apart >= 1 && report_.frames_apart <= kMaxApart) {
    const Residual right_late = measure(storage_.before[0], storage_.now[1]);
    const Residual right_early = measure(storage_.now[0], storage_.before[1]);
    if (report_.frames_apart == 1) {
      vote(same, right_late, right_early);
    } else {
      vote_by_motion(same, right_late, right_early, report_.frames_apart);
    }
  }
  return true;
}

SyncMonitor::Residual SyncMonitor::measure(GrayView left, GrayView right) const noexcept {
  std::array<double, kPoints> rows{};
  std::size_t count = 0;
  if (left.width <= kPatchWidth || left.height <= kPatchHeight + 2 * kMaxRows) {
    return {};
  }
  for (int row = 0; row < kRowsOfCells; ++row) {
    for (int column = 0; column < kColumnsOfCells; ++column) {
      const std::optional<Patch> patch = choose(left, column, row);
      const std::optional<double> shift =
          patch ? row_shift(left, right, *patch, config_.max_disparity_px / 2) : std::nullopt;
      if (shift) {
        rows[count++] = kFullSize * *shift;
      }
    }
  }
  Residual residual{.matches = static_cast<int>(count)};
  if (count > 0) {
    const std::span<double> found(rows.data(), count);
    residual.signed_px = median(found);
    std::transform(found.begin(), found.end(), found.begin(), [](double shift) { return std::abs(shift); });
    residual.median_px = median(found);
  }
  return residual;
}

void SyncMonitor::vote(const Residual& same, const Residual& right_late, const Residual& right_early) noexcept {
  if (std::max({same.matches, right_late.matches, right_early.matches}) < kFewestMatches) {
    return;
  }
  // Images that do not match at all are as far off as can be seen.
  const auto effective_px = [](const Residual& residual) {
    return residual.matches >= kFewestMatches ? residual.median_px : kFullSize * kMaxRows;
  };
  const double same_px = effective_px(same);
  const double late_px = effective_px(right_late);
  const double early_px = effective_px(right_early);
  const double other_px = std::min(late_px, early_px);
  if (same_px > kSurelyOff_px && other_px < kMuchBetter * same_px) {
    cast(late_px < early_px ? SyncVerdict::kRightLate : SyncVerdict::kRightEarly);
  } else if (other_px > kSurelyOff_px && same_px < kMuchBetter * other_px) {
    cast(SyncVerdict::kInStep);
  }
}

// The true partner of a late image is not there: frames in between were skipped. But if rows move by v from frame to
// frame, eyes in step differ by 0, and by n v over n frames either way; with the right eye one frame late it is v, and
// (n - 1) v and (n + 1) v over n frames.
void SyncMonitor::vote_by_motion(const Residual& same, const Residual& right_late, const Residual& right_early,
                                 int frames_apart) noexcept {
  if (std::min({same.matches, right_late.matches, right_early.matches}) < kFewestMatches) {
    return;
  }
  const double motion_px = (right_late.median_px + right_early.median_px) / (2.0 * frames_apart);
  if (motion_px < kMuchMotion_px) {
    return;
  }
  // In frames; both are 0 in step and 1 out of step, as far as motion is even.
  const double late = (right_early.median_px - right_late.median_px) / (2.0 * motion_px);
  const double off = same.median_px / motion_px;
  if (std::abs(late) > kMostlyOff && off > kMostlyOff) {
    cast(late > 0.0 ? SyncVerdict::kRightLate : SyncVerdict::kRightEarly);
  } else if (std::abs(late) < 1.0 - kMostlyOff && off < 1.0 - kMostlyOff) {
    cast(SyncVerdict::kInStep);
  }
}

void SyncMonitor::restart() noexcept {
  pairs_ = 0;
  vote_count_ = 0;
  report_.verdict = SyncVerdict::kUnknown;
  report_.agreeing = 0;
}

void SyncMonitor::cast(SyncVerdict verdict_now) noexcept {
  votes_[vote_count_++ % kVotes] = verdict_now;
  constexpr auto kFewestVotes = static_cast<std::ptrdiff_t>(3);
  const std::size_t count = std::min(vote_count_, kVotes);
  report_.verdict = SyncVerdict::kUnknown;
  report_.agreeing = 0;
  for (const SyncVerdict verdict : {SyncVerdict::kInStep, SyncVerdict::kRightLate, SyncVerdict::kRightEarly}) {
    const auto votes = std::count(votes_.begin(), votes_.begin() + static_cast<std::ptrdiff_t>(count), verdict);
    if (votes >= kFewestVotes && 4 * votes >= 3 * static_cast<std::ptrdiff_t>(count)) {
      report_.verdict = verdict;
      report_.agreeing = static_cast<int>(votes);
    }
  }
}

}  // namespace kinetrace::hal

#include "output/mask_degradation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <vector>

#include "kinetrace/core/detections.hpp"
#include "shading/noise.hpp"
#include "util/random.hpp"

namespace kinetrace::simulator {
namespace {

constexpr std::uint16_t kIdsPerClass = 1000;

std::map<std::uint16_t, int> areas(const Image<std::uint16_t>& labels) {
  std::map<std::uint16_t, int> result;
  std::uint16_t last = 0;
  int* count = nullptr;
  for (const std::uint16_t label : labels.pixels()) {
    if (label == 0) {
      continue;
    }
    if (label != last) {
      last = label;
      count = &result[label];
    }
    ++*count;
  }
  return result;
}

// New ids 1, 2, ... in random order; labels not in `kept` become 0.
std::map<std::uint16_t, std::uint16_t> new_ids(const std::vector<std::uint16_t>& kept, Random& random) {
  std::vector<std::uint16_t> order(kept.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    order[i] = static_cast<std::uint16_t>(i + 1);
    std::swap(order[i], order[static_cast<std::size_t>(random.index(static_cast<int>(i) + 1))]);
  }
  std::map<std::uint16_t, std::uint16_t> ids;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    ids[kept[i]] = static_cast<std::uint16_t>(kept[i] / kIdsPerClass * kIdsPerClass + order[i]);
  }
  return ids;
}

void relabel(Image<std::uint16_t>& labels, const std::map<std::uint16_t, std::uint16_t>& ids) {
  for (std::uint16_t& label : labels.pixels()) {
    const auto found = label == 0 ? ids.end() : ids.find(label);
    label = found == ids.end() ? std::uint16_t{0} : found->second;
  }
}

constexpr int kBorderReach_px = 4;

// In a row of the picture, the columns [begin, end) that can be near a label.
struct Columns {
  int begin = 0;
  int end = 0;
};

std::vector<Columns> columns_near_labels(const Image<std::uint16_t>& labels) {
  std::vector<Columns> own(static_cast<std::size_t>(labels.height()), {labels.width(), 0});
  for (int y = 0; y < labels.height(); ++y) {
    const std::uint16_t* row = &labels.at(0, y);
    const std::uint16_t* end = row + labels.width();
    const std::uint16_t* first = std::find_if(row, end, [](std::uint16_t label) { return label != 0; });
    if (first != end) {
      const auto last = std::find_if(std::reverse_iterator(end), std::reverse_iterator(row),
                                     [](std::uint16_t label) { return label != 0; });
      own[static_cast<std::size_t>(y)] = {static_cast<int>(first - row), static_cast<int>(last.base() - row)};
    }
  }
  std::vector<Columns> near(own.size());
  for (int y = 0; y < labels.height(); ++y) {
    Columns columns{labels.width(), 0};
    for (int at = std::max(y - kBorderReach_px, 0); at <= std::min(y + kBorderReach_px, labels.height() - 1); ++at) {
      columns.begin = std::min(columns.begin, own[static_cast<std::size_t>(at)].begin);
      columns.end = std::max(columns.end, own[static_cast<std::size_t>(at)].end);
    }
    near[static_cast<std::size_t>(y)] = {std::max(columns.begin - kBorderReach_px, 0),
                                         std::min(columns.end + kBorderReach_px, labels.width())};
  }
  return near;
}

// Sets `differences` of a row's pixels between `columns` to non-zero where a nearby pixel has another label. Loops over
// the whole row, so that the compiler can vectorise them.
void find_borders(const Image<std::uint16_t>& labels, int y, const Columns& columns,
                  std::vector<std::uint16_t>& differences) {
  constexpr int kReach = kBorderReach_px;
  constexpr std::array<std::array<int, 2>, 12> kSteps{{{kReach, 0},
                                                       {-kReach, 0},
                                                       {0, kReach},
                                                       {0, -kReach},
                                                       {3, 3},
                                                       {-3, 3},
                                                       {3, -3},
                                                       {-3, -3},
                                                       {2, 0},
                                                       {-2, 0},
                                                       {0, 2},
                                                       {0, -2}}};
  std::fill(differences.begin(), differences.end(), std::uint16_t{0});
  const std::uint16_t* here = &labels.at(0, y);
  std::uint16_t* to = differences.data();
  for (const auto& [dx, dy] : kSteps) {
    if (!labels.contains(0, y + dy)) {
      continue;
    }
    const std::uint16_t* there = &labels.at(0, y + dy);
    const int end = std::min(columns.end, labels.width() - dx);
    for (int x = std::max(columns.begin, -dx); x < end; ++x) {
      to[x] = static_cast<std::uint16_t>(to[x] | (here[x] ^ there[x + dx]));
    }
  }
}

// Smooth noise with a scale of some ten pixels and finer octaves, at eight columns of a row; independent for each
// `field`.
Lanes bumps_at(const Octaves& bumps, const std::array<int, kLanes>& columns, int y, float field) {
  Lanes3 points;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    points.set(i, {static_cast<float>(columns[i]), static_cast<float>(y), field});
  }
  return fractal_noise(bumps, points, Lanes{});
}

// Looks up each pixel at a small offset that varies smoothly over the picture.
Image<std::uint16_t> noisy_borders(const Image<std::uint16_t>& labels, double border_px, std::uint32_t stream) {
  // In units of pixels.
  const Octaves bumps(12.F, 0.6F, 3, stream);
  const auto reach_px = static_cast<float>(border_px) * 0.7F;
  const std::vector<Columns> near = columns_near_labels(labels);
  Image<std::uint16_t> result = labels;
  std::vector<std::uint16_t> differences(static_cast<std::size_t>(labels.width()));
  std::array<int, kLanes> columns{};
  std::size_t count = 0;
  const auto move = [&](int y) {
    const Lanes dx = bumps_at(bumps, columns, y, 0.F);
    const Lanes dy = bumps_at(bumps, columns, y, 500.F);
    for (std::size_t i = 0; i < count; ++i) {
      const int from_x = columns[i] + static_cast<int>(std::lround(dx[i] * reach_px));
      const int from_y = y + static_cast<int>(std::lround(dy[i] * reach_px));
      result.at(columns[i], y) =
          labels.at(std::clamp(from_x, 0, labels.width() - 1), std::clamp(from_y, 0, labels.height() - 1));
    }
    count = 0;
  };
  for (int y = 0; y < labels.height(); ++y) {
    const auto& [begin, end] = near[static_cast<std::size_t>(y)];
    find_borders(labels, y, near[static_cast<std::size_t>(y)], differences);
    for (int x = begin; x < end; ++x) {
      if (differences[static_cast<std::size_t>(x)] != 0) {
        columns[count++] = x;
      }
      if (count == columns.size() || (count > 0 && x + 1 == end)) {
        move(y);
      }
    }
  }
  return result;
}

void invent_object(Image<std::uint16_t>& labels, std::uint16_t label, Random& random) {
  const double radius_x = random.uniform(0.01, 0.04) * labels.width();
  const double radius_y = random.uniform(0.03, 0.09) * labels.height();
  const double cx = random.uniform(0.0, labels.width());
  const double cy = random.uniform(0.3, 0.8) * labels.height();
  for (int y = std::max(0, static_cast<int>(cy - radius_y)); y < std::min<double>(labels.height(), cy + radius_y);
       ++y) {
    for (int x = std::max(0, static_cast<int>(cx - radius_x)); x < std::min<double>(labels.width(), cx + radius_x);
         ++x) {
      const double r = std::hypot((x - cx) / radius_x, (y - cy) / radius_y);
      if (r < 1.0 && labels.at(x, y) == 0) {
        labels.at(x, y) = label;
      }
    }
  }
}

}  // namespace

Image<std::uint16_t> shuffled_masks(const Image<std::uint16_t>& labels, std::uint32_t stream) {
  Random random(stream, 5);
  std::vector<std::uint16_t> present;
  for (const auto& [label, area] : areas(labels)) {
    present.push_back(label);
  }
  Image<std::uint16_t> result = labels;
  relabel(result, new_ids(present, random));
  return result;
}

Image<std::uint16_t> degraded_masks(const Image<std::uint16_t>& labels, const DegradationSettings& settings,
                                    std::uint32_t stream) {
  Image<std::uint16_t> result = noisy_borders(labels, settings.border_px, hash_of(stream, 1));
  std::vector<std::uint16_t> found;
  for (const auto& [label, area] : areas(result)) {
    // Keyed by the object, so that an object added to a scene does not change the misses of the others.
    if (area >= settings.smallest_px && !Random(stream, label, 2).chance(settings.miss_probability)) {
      found.push_back(label);
    }
  }
  Random random(stream, 3);
  constexpr std::uint16_t kInvented = 1999;
  if (random.chance(settings.false_probability)) {
    invent_object(result, kInvented, random);
    found.push_back(kInvented);
  }
  relabel(result, new_ids(found, random));
  return result;
}

}  // namespace kinetrace::simulator

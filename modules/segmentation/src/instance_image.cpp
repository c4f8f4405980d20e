#include "kinetrace/segmentation/instance_image.hpp"

#include <algorithm>
#include <cstring>
#include <numeric>

namespace kinetrace::segmentation {
namespace {

constexpr std::size_t kValueCount = 65536;
constexpr std::uint16_t kBeyondCapacity = 0xFFFF;
constexpr std::uint16_t kMotsIgnore = 10000;
constexpr std::uint16_t kInstanceIgnore = 255;
constexpr std::uint16_t kMotsClassStep = 1000;
/// Noise changes the values of a picture from pixel to pixel; the smallest masks are wider.
constexpr int kMaxPictureRun_px = 4;

/// Calls visit(value, x0, x1) for every run of equal non-zero pixels of a row.
template <typename Visit>
void for_each_run(const std::uint16_t* row, int width, Visit&& visit) {
  int x = 0;
  while (x < width) {
    std::uint64_t four = 0;
    if (x + 4 <= width) {
      std::memcpy(&four, row + x, sizeof four);
      if (four == 0) {  // most of a mask is background
        x += 4;
        continue;
      }
    }
    const std::uint16_t value = row[x];
    const int start = x;
    while (x < width && row[x] == value) {
      ++x;
    }
    if (value != 0) {
      visit(value, start, x);
    }
  }
}

struct Meaning {
  ListedInstance instance;
  bool is_ignored = false;
};

Meaning meaning(std::uint16_t value, MaskEncoding encoding, std::span<const ListedInstance> listed) noexcept {
  switch (encoding) {
    case MaskEncoding::kMots: return {{static_cast<std::uint16_t>(value / kMotsClassStep)}, value == kMotsIgnore};
    case MaskEncoding::kInstance: return {{}, value == kInstanceIgnore};
    case MaskEncoding::kListed: return {listed[value - 1U], listed[value - 1U].class_id == kIgnoreClass};
  }
  return {};
}

}  // namespace

InstanceRelabeler::InstanceRelabeler(Arena& arena)
    : index_of_value_(arena.take<std::uint16_t>(kValueCount)), instances_(arena, kMaxValues) {}

int InstanceRelabeler::relabel(ImageView<const std::uint16_t> source, MaskEncoding encoding, int max_objects,
                               int min_area_px, MutableLabelView labels, FixedVector<Detection>& detections,
                               std::span<const ListedInstance> listed) noexcept {
  collect(source);
  const int dropped = number(encoding, listed, max_objects, min_area_px, detections);
  for (int y = 0; y < source.height; ++y) {
    std::uint8_t* target = labels.row(y);
    std::fill_n(target, labels.width, kBackgroundLabel);
    for_each_run(source.row(y), source.width, [&](std::uint16_t value, int x0, int x1) {
      const std::uint16_t label = index_of_value_[value];
      std::fill(target + x0, target + x1, static_cast<std::uint8_t>(label));
    });
  }
  return dropped;
}

void InstanceRelabeler::collect(ImageView<const std::uint16_t> source) noexcept {
  std::fill(index_of_value_.begin(), index_of_value_.end(), std::uint16_t{0});
  instances_.clear();
  values_beyond_capacity_ = 0;
  runs_ = 0;
  for (int y = 0; y < source.height; ++y) {
    for_each_run(source.row(y), source.width, [&](std::uint16_t value, int x0, int x1) {
      ++runs_;
      std::uint16_t& index = index_of_value_[value];
      if (index == 0) {
        if (!instances_.push_back({value, {}, 0})) {
          index = kBeyondCapacity;
          ++values_beyond_capacity_;
        } else {
          index = static_cast<std::uint16_t>(instances_.size());
        }
      }
      if (index != kBeyondCapacity) {
        Instance& instance = instances_[index - 1U];
        instance.area_px += x1 - x0;
        instance.box_px.include(x0, y);
        instance.box_px.include(x1 - 1, y);
      }
    });
  }
}

bool InstanceRelabeler::is_picture() const noexcept {
  const int area_px = std::accumulate(instances_.begin(), instances_.end(), 0,
                                      [](int sum, const Instance& instance) { return sum + instance.area_px; });
  return instances_.size() > kMaxObjects && area_px < kMaxPictureRun_px * runs_;
}

// Afterwards `index_of_value_` holds the label of each value.
int InstanceRelabeler::number(MaskEncoding encoding, std::span<const ListedInstance> listed, int max_objects,
                              int min_area_px, FixedVector<Detection>& detections) noexcept {
  std::sort(instances_.begin(), instances_.end(), [](const Instance& a, const Instance& b) {
    return a.area_px != b.area_px ? a.area_px > b.area_px : a.value < b.value;
  });
  if (values_beyond_capacity_ > 0) {
    std::replace(index_of_value_.begin(), index_of_value_.end(), kBeyondCapacity, std::uint16_t{kIgnoreLabel});
  }
  detections.clear();
  int dropped = values_beyond_capacity_;
  ignores_all_ = !instances_.empty();
  for (const Instance& instance : instances_) {
    std::uint16_t& label = index_of_value_[instance.value];
    const Meaning what = meaning(instance.value, encoding, listed);
    ignores_all_ = ignores_all_ && what.is_ignored;
    if (what.is_ignored) {
      label = kIgnoreLabel;
    } else if (instance.area_px < min_area_px) {
      label = kBackgroundLabel;
      ++dropped;
    } else if (static_cast<int>(detections.size()) == max_objects) {
      label = kIgnoreLabel;
      ++dropped;
    } else {
      label = static_cast<std::uint16_t>(detections.size() + 1);
      (void)detections.push_back({static_cast<std::uint8_t>(label), what.instance.class_id, what.instance.score,
                                  instance.box_px, instance.area_px});  // checked above
    }
  }
  return dropped;
}

}  // namespace kinetrace::segmentation

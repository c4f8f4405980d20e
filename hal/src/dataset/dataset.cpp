#include "kinetrace/hal/dataset.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "dataset/layouts.hpp"
#include "kinetrace/core/files.hpp"
#include "kinetrace/core/nearest_name.hpp"
#include "util/messages.hpp"

namespace kinetrace::hal {
namespace {

// In the order of DatasetLayout.
constexpr std::array<std::string_view, 7> kLayouts{"kitti-raw",  "kitti-odometry", "kitti-tracking", "euroc",
                                                   "cityscapes", "folder",         "container"};

Result<Dataset> open_layout(const DatasetSpec& spec) {
  switch (spec.layout) {
    case DatasetLayout::kKittiRaw: return open_kitti_raw(spec);
    case DatasetLayout::kKittiOdometry: return open_kitti_odometry(spec);
    case DatasetLayout::kKittiTracking: return open_kitti_tracking(spec);
    case DatasetLayout::kEuroc: return open_euroc(spec);
    case DatasetLayout::kCityscapes: return open_cityscapes(spec);
    case DatasetLayout::kFolder: return open_folder(spec);
    case DatasetLayout::kContainer: return open_container(spec);
  }
  return fail(ErrorCode::kInvalidArgument, "unknown dataset layout");
}

}  // namespace

std::span<const std::string_view> layout_names() noexcept {
  return kLayouts;
}

std::string_view to_string(DatasetLayout layout) noexcept {
  return kLayouts[static_cast<std::size_t>(layout)];
}

Result<DatasetLayout> parse_layout(std::string_view name) {
  const auto* const known = std::find(kLayouts.begin(), kLayouts.end(), name);
  if (known != kLayouts.end()) {
    return static_cast<DatasetLayout>(known - kLayouts.begin());
  }
  return fail(ErrorCode::kInvalidArgument,
              concat("unknown dataset layout '", name,
                     "'; use kitti-raw, kitti-odometry, kitti-tracking, euroc, cityscapes, folder or container",
                     did_you_mean(name, kLayouts)));
}

Result<Dataset> open_dataset(const DatasetSpec& spec) {
  constexpr double kMinRate_hz = 1e-4;
  constexpr double kMaxRate_hz = 1000.0;
  const bool in_range = spec.frame_rate_hz >= kMinRate_hz && spec.frame_rate_hz <= kMaxRate_hz;
  if (spec.frame_rate_hz != 0.0 && !in_range) {
    return fail(
        ErrorCode::kInvalidArgument,
        "dataset.frame_rate_hz must be 0 (as recorded) or in [0.0001, 1000], got " + number(spec.frame_rate_hz));
  }
  if (const Status there = check_folder(spec.path, "no such folder; check the path of the dataset"); !there) {
    return Unexpected(there.error());
  }
  try {
    Result<Dataset> dataset = open_layout(spec);
    if (dataset) {
      dataset->layout = spec.layout;
    }
    return dataset;
  } catch (const std::filesystem::filesystem_error& error) {
    return fail(ErrorCode::kIo, concat(spec.path.string(), ": ", error.what()));
  }
}

}  // namespace kinetrace::hal

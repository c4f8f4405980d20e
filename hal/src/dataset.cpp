#include "kinetrace/hal/dataset.hpp"

#include <array>
#include <cmath>
#include <utility>

#include "image_folder.hpp"
#include "layouts.hpp"
#include "messages.hpp"

namespace kinetrace::hal {
namespace {

constexpr std::array<std::pair<DatasetLayout, std::string_view>, 7> kLayouts{{
    {DatasetLayout::kKittiRaw, "kitti-raw"},
    {DatasetLayout::kKittiOdometry, "kitti-odometry"},
    {DatasetLayout::kKittiTracking, "kitti-tracking"},
    {DatasetLayout::kEuroc, "euroc"},
    {DatasetLayout::kCityscapes, "cityscapes"},
    {DatasetLayout::kFolder, "folder"},
    {DatasetLayout::kContainer, "container"},
}};

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

std::string_view to_string(DatasetLayout layout) noexcept {
  return kLayouts[static_cast<std::size_t>(layout)].second;
}

Result<DatasetLayout> parse_layout(std::string_view name) {
  for (const auto& [layout, known] : kLayouts) {
    if (known == name) {
      return layout;
    }
  }
  return fail(ErrorCode::kInvalidArgument,
              concat("unknown dataset layout '", name,
                     "'; use kitti-raw, kitti-odometry, kitti-tracking, euroc, cityscapes, "
                     "folder or container"));
}

Result<Dataset> open_dataset(const DatasetSpec& spec) {
  constexpr double kMaxRate_hz = 1000.0;
  if (!std::isfinite(spec.frame_rate_hz) || spec.frame_rate_hz < 0 || spec.frame_rate_hz > kMaxRate_hz) {
    return fail(ErrorCode::kInvalidArgument,
                "dataset.frame_rate_hz must be in [0, 1000], got " + number(spec.frame_rate_hz));
  }
  if (!is_folder(spec.path)) {
    return fail(ErrorCode::kNotFound, spec.path.string() + ": no such folder; check the path of the dataset");
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

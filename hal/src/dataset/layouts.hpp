// One function per layout: finds frames and calibration. open_dataset does the common work.
#pragma once

#include "kinetrace/core/result.hpp"
#include "kinetrace/hal/dataset.hpp"

namespace kinetrace::hal {

/// Written by `kinetrace record` beside KITTI's own files: the time of each frame.
inline constexpr const char* kFrameTimesFile = "frames.txt";

[[nodiscard]] Result<Dataset> open_kitti_raw(const DatasetSpec& spec);
[[nodiscard]] Result<Dataset> open_kitti_odometry(const DatasetSpec& spec);
[[nodiscard]] Result<Dataset> open_kitti_tracking(const DatasetSpec& spec);
[[nodiscard]] Result<Dataset> open_euroc(const DatasetSpec& spec);
[[nodiscard]] Result<Dataset> open_cityscapes(const DatasetSpec& spec);
[[nodiscard]] Result<Dataset> open_folder(const DatasetSpec& spec);
[[nodiscard]] Result<Dataset> open_container(const DatasetSpec& spec);

}  // namespace kinetrace::hal

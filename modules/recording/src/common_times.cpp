#include "kinetrace/recording/common_times.hpp"

#include <algorithm>

namespace kinetrace::recording {

CommonTimes common_times(const Run& run, std::vector<std::int64_t> times_ns) {
  std::sort(times_ns.begin(), times_ns.end());
  const auto common = std::count_if(run.camera.begin(), run.camera.end(), [&](const CameraRow& row) {
    return std::binary_search(times_ns.begin(), times_ns.end(), row.timestamp_ns);
  });
  return {std::min(run.camera.size(), times_ns.size()), static_cast<std::size_t>(common)};
}

}  // namespace kinetrace::recording

// A point cloud of a run folder: PLY.
#include "figure/figure_points.hpp"
#include "fuzz_target.hpp"
#include "memory_folder.hpp"

void kinetrace::fuzz::try_input(std::string_view input) {
  static MemoryFolder folder;
  const auto cloud = figure::read_cloud(folder.put("cloud.ply", input), 10);
  require(!cloud || cloud->points.size() <= 10);
}

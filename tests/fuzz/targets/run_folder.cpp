// A run folder: run.json, camera.tum, camera_kitti.txt, objects.csv, and camera_frames.csv unless it is of an earlier
// version.
#include "fuzz_target.hpp"
#include "kinetrace/recording/run_reader.hpp"
#include "memory_folder.hpp"

void kinetrace::fuzz::try_input(std::string_view input) {
  std::vector<std::string> names{"run.json", "camera.tum", "camera_kitti.txt", "objects.csv"};
  static MemoryFolder earlier;
  static MemoryFolder present;
  const bool is_earlier = parts_of(input, names.size() + 1).back().empty();
  if (!is_earlier) {
    names.emplace_back("camera_frames.csv");
  }
  MemoryFolder& folder = is_earlier ? earlier : present;
  folder.put_parts(names, input);
  static_cast<void>(recording::read_run(folder.path()));
}

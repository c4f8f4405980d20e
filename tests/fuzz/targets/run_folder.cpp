// A run folder: run.json, camera.tum, camera_kitti.txt, objects.csv and camera_frames.csv.
#include "fuzz_target.hpp"
#include "kinetrace/recording/run_reader.hpp"
#include "memory_folder.hpp"

void kinetrace::fuzz::try_input(std::string_view input) {
  static MemoryFolder folder;
  folder.put_parts({"run.json", "camera.tum", "camera_kitti.txt", "objects.csv", "camera_frames.csv"}, input);
  static_cast<void>(recording::read_run(folder.path()));
}

// KITTI's tracking labels, with the poses of the camera that they need.
#include "fuzz_target.hpp"
#include "kinetrace/evaluation/truth.hpp"
#include "memory_folder.hpp"

void kinetrace::fuzz::try_input(std::string_view input) {
  static MemoryFolder folder;
  folder.put_parts({"camera.txt", "labels.txt"}, input);
  evaluation::TruthSource source;
  source.path = folder.path() / "labels.txt";
  source.camera = folder.path() / "camera.txt";
  source.frame_times_ns = {{0, 0}, {1, 100'000'000}, {2, 200'000'000}};
  static_cast<void>(evaluation::read_truth(source));
}

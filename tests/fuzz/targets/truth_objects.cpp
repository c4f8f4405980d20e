// The simulator's truth: camera_poses.txt and objects.csv.
#include "fuzz_target.hpp"
#include "kinetrace/evaluation/truth.hpp"
#include "memory_folder.hpp"

void kinetrace::fuzz::try_input(std::string_view input) {
  static MemoryFolder folder;
  folder.put_parts({"camera_poses.txt", "objects.csv"}, input);
  evaluation::TruthSource source;
  source.path = folder.path();
  source.frame_times_ns = {{0, 0}, {1, 100'000'000}, {2, 200'000'000}};
  static_cast<void>(evaluation::read_truth(source));
}

// Files of true poses: KITTI's, TUM's and EuRoC's, distinguished by their first row.
#include "fuzz_target.hpp"
#include "kinetrace/evaluation/truth.hpp"
#include "memory_folder.hpp"

void kinetrace::fuzz::try_input(std::string_view input) {
  static MemoryFolder folder;
  evaluation::TruthSource source;
  source.path = folder.put("truth.txt", input);
  source.T_body_cam = Se3{};
  const auto truth = evaluation::read_truth(source);
  if (truth) {
    static_cast<void>(truth->camera.at(1, 1'000'000'000, source.time_tolerance_ns));
  }
}

// The masks of a run folder: mots.txt.
#include "fuzz_target.hpp"
#include "kinetrace/recording/mask_frames.hpp"
#include "memory_folder.hpp"

void kinetrace::fuzz::try_input(std::string_view input) {
  static MemoryFolder folder;
  folder.put("mots.txt", input);
  recording::Run run;
  run.directory = folder.path();
  run.rectified.width_px = 48;
  run.rectified.height_px = 32;
  auto frames = recording::MaskFrames::open(run);
  for (std::int64_t frame = 0; frames && frame < 3; ++frame) {
    static_cast<void>(frames->at(frame));
  }
}

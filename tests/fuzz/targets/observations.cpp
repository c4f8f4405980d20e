// A run's observations: observations.bin.
#include "kinetrace/recording/observations.hpp"

#include "fuzz_target.hpp"
#include "memory_folder.hpp"

void kinetrace::fuzz::try_input(std::string_view input) {
  static MemoryFolder folder;
  folder.put("observations.bin", input);
  recording::Run run;
  run.directory = folder.path();
  run.is_finished = false;
  auto reader = recording::ObservationReader::open(run);
  while (reader) {
    const auto frame = reader->next_frame();
    if (!frame || frame->empty()) {
      break;
    }
  }
}

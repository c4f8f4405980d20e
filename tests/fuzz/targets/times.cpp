// Files of times: timestamps.txt, and the recorder's frames.txt.
#include "fuzz_target.hpp"
#include "memory_folder.hpp"
#include "util/text_file.hpp"

void kinetrace::fuzz::try_input(std::string_view input) {
  static MemoryFolder folder;
  const std::string& path = folder.put("times.txt", input);
  static_cast<void>(hal::read_times_ns(path));
  static_cast<void>(hal::read_frame_times_ns(path));
}

// The index of a recorded MCAP file, rebuilt from the file's bytes.
#include "fuzz_target.hpp"
#include "mcap_file.hpp"
#include "memory_folder.hpp"

void kinetrace::fuzz::try_input(std::string_view input) {
  using namespace recording;
  static MemoryFolder folder;
  McapFile file;
  file.path = folder.put("run.mcap", input);
  file.file = open_file(file.path, OpenMode::kUpdate).value();
  file.end = input.size();
  McapContent content;
  content.schemas.push_back({"type", "definition"});
  content.channels.push_back({"/topic", 1, {{"key", "value"}}});
  static_cast<void>(write_mcap_summary(file, content));
}

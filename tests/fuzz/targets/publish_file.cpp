// The file that says what is published.
#include "fuzz_target.hpp"
#include "memory_folder.hpp"
#include "publish_config_file.hpp"

void kinetrace::fuzz::try_input(std::string_view input) {
  static MemoryFolder folder;
  static_cast<void>(app::load_publish_config(folder.put("dds.yaml", input)));
}

// The configuration file of publishing.
#include "dds/publish_config_file.hpp"
#include "fuzz_target.hpp"
#include "memory_folder.hpp"

void kinetrace::fuzz::try_input(std::string_view input) {
  static MemoryFolder folder;
  static_cast<void>(app::load_publish_config(folder.put("dds.yaml", input)));
}

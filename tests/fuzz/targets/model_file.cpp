// The YAML file beside a neural network.
#include "segmentation/model_file.hpp"

#include "fuzz_target.hpp"
#include "memory_folder.hpp"

void kinetrace::fuzz::try_input(std::string_view input) {
  static MemoryFolder folder;
  static_cast<void>(app::load_model(folder.put("model.yaml", input)));
}

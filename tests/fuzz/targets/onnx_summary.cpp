// A neural network as an ONNX file: the summary read before a library loads it.
#include "onnx_summary.hpp"

#include "fuzz_target.hpp"
#include "memory_folder.hpp"

void kinetrace::fuzz::try_input(std::string_view input) {
  static MemoryFolder folder;
  static_cast<void>(neural::summarize_onnx(folder.put("model.onnx", input)));
}

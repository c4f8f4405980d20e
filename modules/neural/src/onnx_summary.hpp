// Contents of an ONNX file that decide whether the runtime can compute it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "kinetrace/core/result.hpp"

namespace kinetrace::neural {

/// Read from the file itself (ONNX IR, onnx.proto3; Protocol Buffers encoding), since OpenCV silently computes some
/// models wrongly, and refuses others with a trace of its own source.
struct OnnxSummary {
  std::int64_t opset = 0;
  std::vector<std::string> operators;  ///< Each once, sorted.
  std::vector<std::int64_t> input;     ///< Sizes of the first input; 0 where the file gives a name instead.
  std::string weights_not_finite;      ///< The first tensor with a value that is not finite; empty if none.
  bool has_uneven_split = false;       ///< With sizes given as an input, from opset 13 on.
};

/// Errors: kNotFound, kIo, kBadFormat (not an ONNX model, or cut off).
[[nodiscard]] Result<OnnxSummary> summarize_onnx(const std::string& file);

}  // namespace kinetrace::neural

// A run and its truth, laid side by side.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "kinetrace/core/result.hpp"
#include "kinetrace/evaluation/evaluation.hpp"
#include "kinetrace/evaluation/truth.hpp"
#include "kinetrace/recording/run_reader.hpp"

namespace kinetrace::app {

/// The frames that both run and truth know. The true world is turned into the run's by the first common camera pose.
struct EvaluationInput {
  std::vector<evaluation::PosePair> camera;
  std::optional<double> camera_rotation_deg;
  evaluation::Association association = evaluation::Association::kMasks;
  std::vector<evaluation::ObjectFrame> objects;
  std::optional<evaluation::MaskReport> masks;
  std::vector<std::string> notes;  ///< What was left out, one line each.
};

/// Errors: those of the mask files; kBadFormat (no frame in common; images of different size), kInvalidArgument (the
/// wanted association needs what run or truth do not have). `association`: none for the best there is.
[[nodiscard]] Result<EvaluationInput> match_up(const recording::Run& run, const evaluation::Truth& truth,
                                               std::int64_t time_tolerance_ns,
                                               std::optional<evaluation::Association> association, double gate_m);

}  // namespace kinetrace::app

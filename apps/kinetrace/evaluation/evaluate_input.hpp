// Pairs a run with its ground truth.
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

/// The frames common to run and ground truth. The first common camera pose aligns the true world with the run's.
struct EvaluationInput {
  std::vector<evaluation::PosePair> camera;
  std::optional<double> camera_rotation_deg;
  evaluation::Association association = evaluation::Association::kMasks;
  std::vector<evaluation::ObjectFrame> objects;
  std::optional<evaluation::MaskReport> masks;
  std::vector<std::string> notes;  ///< Omissions, one line each.
};

/// Errors: those of the mask files; kBadFormat (no frame in common; images of different size), kInvalidArgument (run or
/// ground truth lack the data for the requested association). `association`: none: the best available.
[[nodiscard]] Result<EvaluationInput> match_up(const recording::Run& run, const evaluation::Truth& truth,
                                               std::int64_t time_tolerance_ns,
                                               std::optional<evaluation::Association> association, double gate_m);

}  // namespace kinetrace::app

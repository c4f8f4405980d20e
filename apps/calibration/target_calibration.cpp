#include "target_calibration.hpp"

#include <algorithm>
#include <numbers>

#include "report_text.hpp"

namespace kinetrace::calibration {
namespace {

constexpr double kMaxFocalSigma = 3e-3;  // Relative.
constexpr double kGoodFocalSigma = 1e-3;
constexpr double kMaxRotationSigma_rad = 0.05 * std::numbers::pi / 180.0;
constexpr double kMaxSigma_px = 1.0;  // Of a corner's coordinate.
constexpr double kGoodSigma_px = 0.3;
constexpr double kMaxRejected = 0.4;  // Part of the views.

std::string joined(const std::vector<std::string>& parts) {
  std::string all;
  for (const std::string& part : parts) {
    all += (all.empty() ? "" : "; ") + part;
  }
  return all;
}

std::vector<std::string> problems_of(const StereoEstimate& estimate) {
  std::vector<std::string> problems;
  if (estimate.sigma_px > kMaxSigma_px) {
    problems.push_back(
        formatted("corners lie %.2f px off where the estimate has them; is the target flat, the lens "
                  "model right, are both images of the same moment?",
                  estimate.sigma_px));
  }
  const auto all = static_cast<double>(estimate.used_views.size() + estimate.rejected_views);
  if (static_cast<double>(estimate.rejected_views) > kMaxRejected * all) {
    problems.push_back(
        formatted("%.0f %% of the views contradict the others; hold the target still, and check that both "
                  "cameras take their images together",
                  100.0 * static_cast<double>(estimate.rejected_views) / all));
  }
  if (estimate.relative_focal_sigma() > kMaxFocalSigma) {
    problems.push_back(
        formatted("the focal length is known to %.2f %% only; show the target tilted by 30 to 45 deg, nearer, "
                  "and in more places",
                  100.0 * estimate.relative_focal_sigma()));
  }
  if (estimate.rotation_sigma_rad() > kMaxRotationSigma_rad) {
    problems.push_back(
        formatted("the rotation between the views is known to %.3f deg only; show the target in more places",
                  estimate.rotation_sigma_rad() * kDegrees));
  }
  return problems;
}

std::vector<std::string> warnings_of(const StereoEstimate& estimate, const Assessment& assessment) {
  std::vector<std::string> warnings;
  if (estimate.sigma_px > kGoodSigma_px) {
    warnings.push_back(formatted("corners lie %.2f px off, usual is 0.1 px: blur, a bent target, or another lens model",
                                 estimate.sigma_px));
  }
  if (estimate.relative_focal_sigma() > kGoodFocalSigma) {
    warnings.push_back(formatted("the focal length is known to %.2f %%", 100.0 * estimate.relative_focal_sigma()));
  }
  if (!assessment.missing.empty()) {
    warnings.push_back("would be better with more: " + joined(assessment.missing));
  }
  return warnings;
}

}  // namespace

Result<TargetCalibration> calibrate(const Target& target, const ViewCollector& views,
                                    const EstimationOptions& options) {
  const Assessment assessment = views.assess();
  if (!assessment.refusals.empty()) {
    return fail(ErrorCode::kBadCalibration, joined(assessment.refusals));
  }
  std::vector<BoardView> used;
  std::vector<BoardView> left_out;
  for (std::size_t i = 0; i < views.views().size(); ++i) {
    constexpr std::size_t kLeaveOutEvery = 5;
    (i % kLeaveOutEvery == kLeaveOutEvery - 1 ? left_out : used).push_back(views.views()[i]);
  }
  auto estimate = estimate_stereo(target, used, options);
  if (!estimate) {
    return Unexpected(estimate.error());
  }
  const Validation validation = validate(estimate->rig, target, left_out);
  // Once more, from all views.
  auto from_all = estimate_stereo(target, views.views(), options);
  if (!from_all) {
    return Unexpected(from_all.error());
  }
  if (const auto problems = problems_of(*from_all); !problems.empty()) {
    return fail(ErrorCode::kBadCalibration, joined(problems));
  }
  TargetCalibration calibration{.estimate = std::move(*from_all), .validation = validation, .warnings = {}};
  calibration.warnings = warnings_of(calibration.estimate, assessment);
  return calibration;
}

}  // namespace kinetrace::calibration

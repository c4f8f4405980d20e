#include "reference_factors.hpp"

#include <array>
#include <cstdio>

#include "cli/messages.hpp"
#include "kinetrace/geo/reference.hpp"
#include "reference_arguments.hpp"
#include "reference_fit.hpp"

namespace kinetrace::batch {
namespace {

HeldPath describe(const ReferenceFit& fit) {
  std::array<char, 256> text;
  std::snprintf(text.data(), text.size(),
                "Held the path by %lld of %lld fixes (%.2f m horizontally, %.2f m vertically), which moved it by up to "
                "%.2f m and scaled it by %+.2f %%",
                static_cast<long long>(fit.alignment.inliers), static_cast<long long>(fit.alignment.fixes),
                fit.alignment.horizontal_noise_m, fit.alignment.vertical_noise_m, fit.moved_m,
                100.0 * (fit.scale - 1.0));
  return {fit.scale, text.data()};
}

}  // namespace

app::Outcome<HoldPath> read_reference(const recording::Run& run, const app::ReferenceOptions& options,
                                      const AdjustmentOptions& adjustment) {
  if (options.source.empty()) {
    return HoldPath{};
  }
  const app::Outcome<geo::AlignmentConfig> config = map::parse_config(options);
  if (!config) {
    return Unexpected(config.error());
  }
  const app::Outcome<geo::ReferenceSource> source = map::parse_source(options, run.camera.front().timestamp_ns);
  if (!source) {
    return Unexpected(source.error());
  }
  Result<geo::Reference> reference = geo::read_reference(*source);
  if (!reference) {
    return app::failure(reference.error());
  }
  for (const std::string& note : reference->notes) {
    app::print_warning(note);
  }
  return [&run, &adjustment, config = *config, fixes = std::move(reference->fixes)](
             const PathGraph& graph, RefinedCamera& camera) -> app::Outcome<HeldPath> {
    const Result<ReferenceFit> fit = fit_to_reference(run, fixes, config, graph, adjustment, camera);
    if (!fit) {
      return app::failure(fit.error());
    }
    return describe(*fit);
  };
}

}  // namespace kinetrace::batch

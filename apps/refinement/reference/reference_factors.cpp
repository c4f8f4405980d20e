#include "reference_factors.hpp"

#include <array>
#include <cstdio>

#include "cli/messages.hpp"
#include "kinetrace/geo/reference.hpp"
#include "reference_arguments.hpp"
#include "reference_fit.hpp"

namespace kinetrace::batch {

app::Outcome<HeldPath> hold_by_reference(const recording::Run& run, const app::ReferenceOptions& options,
                                         const PathGraph& graph, const AdjustmentOptions& adjustment,
                                         RefinedCamera& camera) {
  const app::Outcome<geo::AlignmentConfig> config = map::parse_config(options);
  if (!config) {
    return Unexpected(config.error());
  }
  const app::Outcome<geo::ReferenceSource> source = map::parse_source(options, run.camera.front().timestamp_ns);
  if (!source) {
    return Unexpected(source.error());
  }
  const Result<geo::Reference> reference = geo::read_reference(*source);
  if (!reference) {
    return app::failure(reference.error());
  }
  for (const std::string& note : reference->notes) {
    app::print_warning(note);
  }
  const Result<ReferenceFit> fit = fit_to_reference(run, reference->fixes, *config, graph, adjustment, camera);
  if (!fit) {
    return app::failure(fit.error());
  }
  std::array<char, 256> text;
  std::snprintf(text.data(), text.size(),
                "Held the path by %lld of %lld fixes (%.2f m horizontally, %.2f m vertically), which moved it by up to "
                "%.2f m and scaled it by %+.2f %%",
                static_cast<long long>(fit->alignment.inliers), static_cast<long long>(fit->alignment.fixes),
                fit->alignment.horizontal_noise_m, fit->alignment.vertical_noise_m, fit->moved_m,
                100.0 * (fit->scale - 1.0));
  return HeldPath{fit->scale, text.data()};
}

}  // namespace kinetrace::batch

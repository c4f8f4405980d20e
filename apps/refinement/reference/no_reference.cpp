// Replacement in a program built without maps.
#include "reference_factors.hpp"

namespace kinetrace::batch {

app::Outcome<HoldPath> read_reference(const recording::Run& /*run*/, const app::ReferenceOptions& options,
                                      const AdjustmentOptions& /*adjustment*/) {
  if (options.source.empty()) {
    return HoldPath{};
  }
  return Unexpected(app::Failure{app::ExitCode::kUsage,
                                 "--reference: this program has been built without maps; install the packages for them "
                                 "that toolchains/packages-build.txt names and build again"});
}

}  // namespace kinetrace::batch

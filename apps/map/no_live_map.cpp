// Replacement in a program built without DDS.
#include "live_map.hpp"

namespace kinetrace::map {

app::Outcome<int> follow_run(const app::MapOptions& /*options*/) {
  return Unexpected(app::Failure{app::ExitCode::kUsage,
                                 "--reference navsatfix: this program has been built without DDS; install the packages "
                                 "for it that toolchains/packages-build.txt names and build again"});
}

}  // namespace kinetrace::map

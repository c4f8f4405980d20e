// Publishing in a program built without DDS.
#include "dds/run_publishing.hpp"

namespace kinetrace::app {

Outcome<std::unique_ptr<PublishingSetup>> publishing_setup(const std::string& file, int /*max_objects*/) {
  return Unexpected(
      Failure{ExitCode::kUsage, "--publish " + file +
                                    ": this program has been built without DDS; install the packages for it that "
                                    "toolchains/packages-build.txt names and build again"});
}

}  // namespace kinetrace::app

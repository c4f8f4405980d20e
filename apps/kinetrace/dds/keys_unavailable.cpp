#include "cli/messages.hpp"
#include "dds/dds_command_line.hpp"

namespace kinetrace::app {

int keys_command(const KeysOptions& /*options*/) {
  return report({ExitCode::kUsage, "this program was built without DDS; build it with KINETRACE_WITH_DDS=ON"});
}

}  // namespace kinetrace::app

// DDS commands of a program built without DDS.
#include <string>

#include "cli/messages.hpp"
#include "dds/dds_command_line.hpp"
#include "dds/doctor_dds.hpp"

namespace kinetrace::app {
namespace {

const std::string kNotBuilt =
    ": this program has been built without DDS; install the packages for it that toolchains/packages-build.txt names "
    "and build again";

int refuse(const char* command) {
  return report({ExitCode::kUsage, command + kNotBuilt});
}

}  // namespace

NetworkFinding examine_network(const std::string& file) {
  return file.empty() ? NetworkFinding{true, "not built in"} : NetworkFinding{false, "--publish" + kNotBuilt};
}

int monitor_command(const MonitorOptions& /*options*/) {
  return refuse("monitor");
}

int mask_command(const MaskOptions& /*options*/) {
  return refuse("masks");
}

}  // namespace kinetrace::app

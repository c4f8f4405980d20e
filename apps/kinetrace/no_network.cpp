// Of a program that has been built without DDS.
#include <string>

#include "commands.hpp"
#include "messages.hpp"

namespace kinetrace::app {
namespace {

int refuse(const char* command) {
  return report({ExitCode::kUsage, std::string(command) +
                                       ": this program has been built without DDS; install the packages for it that "
                                       "toolchains/packages-build.txt names and build again"});
}

}  // namespace

int monitor_command(const MonitorOptions& /*options*/) {
  return refuse("monitor");
}

int mask_command(const MaskOptions& /*options*/) {
  return refuse("masks");
}

}  // namespace kinetrace::app

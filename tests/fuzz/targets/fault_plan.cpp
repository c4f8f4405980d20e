// Fault plans of --fault and camera files.
#include "fuzz_target.hpp"
#include "kinetrace/hal/fault_injector.hpp"

void kinetrace::fuzz::try_input(std::string_view input) {
  static_cast<void>(hal::parse_faults(input));
}

// The description of a calibration target: in its short form, and as a file.
#include "fuzz_target.hpp"
#include "memory_folder.hpp"
#include "target.hpp"

void kinetrace::fuzz::try_input(std::string_view input) {
  static MemoryFolder folder;
  const auto parts = parts_of(input, 2);
  for (const auto& target :
       {calibration::parse_target(parts[0]), calibration::read_target(folder.put("target.yaml", parts[1]))}) {
    if (target) {
      require(!target->points_m.empty() && !target->description().empty() && target->extent_m().allFinite());
    }
  }
}

// A receiver's log in NMEA 0183.
#include "fuzz_target.hpp"
#include "kinetrace/geo/reference.hpp"
#include "memory_folder.hpp"

void kinetrace::fuzz::try_input(std::string_view input) {
  static MemoryFolder folder;
  const auto reference =
      geo::read_reference({geo::ReferenceFormat::kNmea, folder.put("log.nmea", input), {}, 1'317'042'000'000'000'000});
  if (reference) {
    for (std::size_t i = 0; i < reference->fixes.size(); ++i) {
      require(reference->fixes[i].enu_m.allFinite());
      require(i == 0 || reference->fixes[i].time_ns > reference->fixes[i - 1].time_ns);
    }
  }
}

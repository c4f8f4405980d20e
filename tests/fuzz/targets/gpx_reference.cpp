// Tracks in GPX.
#include "fuzz_target.hpp"
#include "kinetrace/geo/reference.hpp"
#include "memory_folder.hpp"

void kinetrace::fuzz::try_input(std::string_view input) {
  static MemoryFolder folder;
  const auto reference = geo::read_reference({geo::ReferenceFormat::kGpx, folder.put("track.gpx", input), {}, 0});
  require(!reference || reference->fixes.front().enu_m.allFinite());
}

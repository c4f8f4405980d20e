// References as tables: EuRoC's ground truth, columns by name, and KITTI's oxts folder.
#include "fuzz_target.hpp"
#include "kinetrace/geo/reference.hpp"
#include "memory_folder.hpp"

void kinetrace::fuzz::try_input(std::string_view input) {
  static MemoryFolder folder;
  folder.put_parts({"truth.csv", "fixes.csv", "oxts/timestamps.txt", "oxts/data/0000000000.txt"}, input);
  using geo::ReferenceFormat;
  const auto try_one = [](ReferenceFormat format, const char* name) {
    const auto reference = geo::read_reference({format, folder.path() / name, geo::Geodetic{49.0, 8.4, 110.0}, 0});
    require(!reference || reference->fixes.front().enu_m.allFinite());
  };
  try_one(ReferenceFormat::kEuroc, "truth.csv");
  try_one(ReferenceFormat::kCsv, "fixes.csv");
  try_one(ReferenceFormat::kOxts, "oxts");
}

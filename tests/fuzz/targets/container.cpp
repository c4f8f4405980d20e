// A file of a container recording. An input is the header's numbers, the numbers of each record, and a calibration. The
// target computes the checksums, which no fuzzer finds.
#include <array>
#include <fuzzer/FuzzedDataProvider.h>
#include <vector>

#include "formats/container_file.hpp"
#include "fuzz_target.hpp"
#include "kinetrace/hal/dataset.hpp"
#include "memory_folder.hpp"

void kinetrace::fuzz::try_input(std::string_view input) {
  static MemoryFolder folder;
  FuzzedDataProvider values(reinterpret_cast<const std::uint8_t*>(input.data()), input.size());
  hal::ContainerHeader header;
  const bool is_small = values.ConsumeBool();
  header.width_px = is_small ? values.ConsumeIntegralInRange(1, 4) : values.ConsumeIntegral<int>();
  header.height_px = is_small ? values.ConsumeIntegralInRange(1, 4) : values.ConsumeIntegral<int>();
  header.rate_hz = values.ConsumeFloatingPoint<double>();
  std::string records;
  const int count = values.ConsumeIntegralInRange(0, 6);
  for (int i = 0; i < count; ++i) {
    std::array<std::byte, hal::kRecordHeaderBytes> record{};
    hal::encode_record_header({values.ConsumeIntegral<std::int64_t>(), values.ConsumeIntegral<std::int64_t>(), 0},
                              record);
    record[0] = values.ConsumeBool() ? std::byte{0} : record[0];
    records.append(reinterpret_cast<const char*>(record.data()), record.size());
    records.append(is_small ? hal::record_pixel_bytes(header.width_px, header.height_px) : 0, '\0');
  }
  records.resize(records.size() -
                 values.ConsumeIntegralInRange<std::size_t>(0, std::min<std::size_t>(records.size(), 64)));
  header.calibration = values.ConsumeRemainingBytesAsString();
  if (const auto bytes = hal::encode_header(header)) {
    folder.put("recording.ktraw", *bytes + records);
    const auto dataset = hal::open_dataset({.layout = hal::DatasetLayout::kContainer, .path = folder.path()});
    require(!dataset || dataset->frames.size() <= static_cast<std::size_t>(count));
  }
}

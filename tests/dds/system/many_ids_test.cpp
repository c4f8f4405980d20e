// Tracks begin and end for weeks; neither writer's nor reader's memory may grow with them.
#include <gtest/gtest.h>

#include "network.hpp"
#include "parts.hpp"

namespace kinetrace::test {
namespace {

constexpr std::int64_t kIds = 100'000;
constexpr std::int64_t kWarm = 30'000;  ///< Buffers reach their final size until here.
constexpr std::int64_t kSlack_kib = 1024;

class DdsMemory : public OwnNetworkTest {};

TEST_F(DdsMemory, StaysFlatOverAHundredThousandIds) {
  const Process scene(scene_command(
      {"--new-ids", "--objects", "50", "--rate", "200", "dds.max_points=100", "dds.bytes_per_second=1000000000"}));
  const Process ros(local_fast_reader_command({"--no-check"}));
  const Process native(native_reader_command());
  const auto resident = [&] {
    return std::array<std::int64_t, 3>{static_cast<std::int64_t>(scene.resident_kib()),
                                       static_cast<std::int64_t>(ros.resident_kib()),
                                       static_cast<std::int64_t>(native.resident_kib())};
  };
  ASSERT_TRUE(native.until(all_topics_have(1))) << native.report();
  ASSERT_TRUE(ros.until(at_least("detections", kWarm))) << ros.report() << scene.report();
  const std::array<std::int64_t, 3> before = resident();
  ASSERT_TRUE(ros.until(at_least("detections", kIds))) << ros.report() << scene.report();
  const std::array<std::int64_t, 3> after = resident();
  const std::array<const char*, 3> names{"publisher", "reader of ROS 2 topics", "reader of native topics"};
  for (std::size_t i = 0; i < names.size(); ++i) {
    EXPECT_GT(before[i], 0) << names[i];
    EXPECT_LT(after[i] - before[i], kSlack_kib) << names[i] << ": " << before[i] << " to " << after[i] << " KiB";
    RecordProperty(std::string(names[i]) + " KiB", std::to_string(before[i]) + " to " + std::to_string(after[i]));
  }
}

}  // namespace
}  // namespace kinetrace::test

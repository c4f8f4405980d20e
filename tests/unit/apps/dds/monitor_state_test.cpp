// State that monitor keeps of received messages.
#include "dds/monitor_state.hpp"

#include <cmath>
#include <limits>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "dds/monitor_output.hpp"

namespace kinetrace::app {
namespace {

using publishing::ReceivedCamera;
using publishing::ReceivedHealth;
using publishing::ReceivedObjects;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr std::int64_t kSecond_ns = 1'000'000'000;

ObjectResult object(std::uint32_t id) {
  ObjectResult result;
  result.track_id = id;
  return result;
}

void hear_objects(MonitorState& state, std::int64_t frame, std::vector<ObjectResult> objects, std::uint32_t piece = 0,
                  std::uint32_t pieces = 1) {
  state.receive(ReceivedObjects{"front", frame, frame * kSecond_ns, piece, pieces, objects});
}

std::vector<std::uint32_t> ids(const MonitoredDevice& device) {
  std::vector<std::uint32_t> all;
  for (const MonitoredObject& shown : device.objects) {
    all.push_back(shown.result.track_id);
  }
  return all;
}

TEST(RateWindow, CountsWhatCameInTheLastTwoSeconds) {
  RateWindow rate;
  EXPECT_EQ(rate.rate_hz(0), 0.0);
  rate.add(0);
  EXPECT_EQ(rate.rate_hz(0), 0.0) << "one is no rate";
  for (int i = 1; i <= 40; ++i) {
    rate.add(i * kSecond_ns / 10);
  }
  EXPECT_NEAR(rate.rate_hz(4 * kSecond_ns), 10.0, 1e-9);
  EXPECT_EQ(rate.rate_hz(7 * kSecond_ns), 0.0) << "silence";
  // More than its capacity, so that the ring has wrapped around.
  for (int i = 0; i < 1000; ++i) {
    rate.add(10 * kSecond_ns + i * kSecond_ns / 100);
  }
  EXPECT_NEAR(rate.rate_hz(10 * kSecond_ns + 999 * (kSecond_ns / 100)), 100.0, 1e-6);
}

TEST(MonitorState, PutsPiecesTogetherAndShowsWholeFramesOnly) {
  MonitorState state("");
  hear_objects(state, 1, {object(3)}, 0, 2);
  ASSERT_EQ(state.devices().size(), 1U);
  EXPECT_THAT(ids(state.devices()[0]), ElementsAre());
  hear_objects(state, 1, {object(1)}, 1, 2);
  EXPECT_THAT(ids(state.devices()[0]), ElementsAre(1, 3));
  // The second piece of frame 2 was lost, and the first of the next one.
  hear_objects(state, 2, {object(7)}, 0, 2);
  hear_objects(state, 3, {object(7)}, 1, 2);
  EXPECT_THAT(ids(state.devices()[0]), ElementsAre(1, 3));
  hear_objects(state, 4, {object(8)});
  EXPECT_THAT(ids(state.devices()[0]), ElementsAre(8));
}

TEST(MonitorState, AgeIsTheSourcesTimeSinceAnObjectWasReceivedFirst) {
  MonitorState state("");
  hear_objects(state, 10, {object(1)});
  hear_objects(state, 12, {object(1), object(2)});
  const MonitoredDevice& device = state.devices()[0];
  EXPECT_EQ(device.objects[0].age_s, 2.0);
  EXPECT_EQ(device.objects[1].age_s, 0.0);
}

TEST(MonitorState, ForgetsTheOldestObjectsAndTakesNoMoreDevicesThanItMay) {
  MonitorState state("");
  hear_objects(state, 0, {object(0)});
  for (std::uint32_t id = 1; id <= MonitorState::kMaxIds; ++id) {
    hear_objects(state, id, {object(id)});
  }
  hear_objects(state, 5000, {object(0), object(2)});
  EXPECT_EQ(state.devices()[0].objects[0].age_s, 0.0) << "forgotten";
  EXPECT_EQ(state.devices()[0].objects[1].age_s, 4998.0);
  for (std::size_t i = 0; i < 2 * MonitorState::kMaxDevices; ++i) {
    ReceivedCamera camera;
    const std::string name = "device" + std::to_string(i);
    camera.device = name;
    state.receive(camera);
  }
  EXPECT_EQ(state.devices().size(), MonitorState::kMaxDevices);
}

TEST(MonitorState, TakesNoEndlessPiecesOfOneFrame) {
  MonitorState state("");
  for (std::uint32_t piece = 0; piece < 100; ++piece) {
    hear_objects(state, 1, std::vector<ObjectResult>(kMaxObjects, object(piece)), piece, 100);
  }
  EXPECT_EQ(state.devices()[0].objects.size(), MonitorState::kMaxIds);
}

TEST(MonitorState, HearsOnlyTheDeviceThatIsWanted) {
  MonitorState state("rear");
  hear_objects(state, 1, {object(1)});
  EXPECT_TRUE(state.devices().empty());
  EXPECT_EQ(state.messages(), 0U);
  EXPECT_EQ(state.other_device(), "front");
  ReceivedHealth health;
  health.device = "rear";
  health.state = HealthState::kOk;
  state.receive(health);
  EXPECT_EQ(state.devices().size(), 1U);
  EXPECT_EQ(state.messages(), 1U);
}

TEST(MonitorState, TakesAnyTimes) {
  for (const std::int64_t extreme :
       {std::numeric_limits<std::int64_t>::min(), std::numeric_limits<std::int64_t>::max()}) {
    MonitorState state("");
    state.set_time(0, -1 - extreme);
    ReceivedCamera camera;
    camera.device = "front";
    camera.handed_over_ns = extreme;
    state.receive(camera);
    const std::vector<ObjectResult> seen{object(1)};
    state.receive(ReceivedObjects{"front", 1, -1 - extreme, 0, 1, seen});
    state.receive(ReceivedObjects{"front", 2, extreme, 0, 1, seen});
    const MonitoredDevice& device = state.devices()[0];
    EXPECT_NEAR(std::abs(device.delay_ms), 18446744073709.55, 1.0);
    EXPECT_NEAR(std::abs(device.objects[0].age_s), 18446744073.7, 0.1);
  }
}

TEST(MonitorTable, ShowsNoTerminalWhatOthersSend) {
  MonitorState state("");
  const std::string name = "\x1b[31mEVIL\x1b]0;pwn\x07";
  ReceivedHealth health;
  health.device = name;
  health.camera =
      "\xc2\x9b"
      "2J";
  const std::vector<publishing::ReceivedReason> reasons{{"a\nb\xff", 1, 0, 0}};
  health.reasons = reasons;
  state.receive(health);
  const std::string table = monitor_table(state, 0);
  EXPECT_THAT(table, HasSubstr("\\x1b[31mEVIL\\x1b]0;pwn\\x07: poses"));
  EXPECT_THAT(table, HasSubstr("camera \\xc2\\x9b2J, a\\x0ab\\xff 1x\n"));
  const std::string json = rates_json(state.devices()[0], 0);
  EXPECT_THAT(json, HasSubstr("\\u001b[31mEVIL"));
  health.device = "\xc2\x9b";
  state.receive(health);
  EXPECT_THAT(rates_json(state.devices()[1], 0), HasSubstr("\"\\u009b\""));
}

TEST(MonitorTable, SaysWhatWasNotReceivedYet) {
  MonitorState state("");
  hear_objects(state, 1, {});
  const std::string table = monitor_table(state, 0);
  EXPECT_THAT(table, HasSubstr("no pose yet"));
  EXPECT_THAT(table, HasSubstr("health      not received yet"));
  EXPECT_THAT(table, HasSubstr("calibration not received yet"));
  EXPECT_THAT(table, Not(HasSubstr("class"))) << "no heading without objects";
}

}  // namespace
}  // namespace kinetrace::app

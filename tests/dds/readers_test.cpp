// The publisher's messages, as received by our own readers.
#include <cstring>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetrace/publishing/result_reader.hpp"
#include "kinetrace/publishing/ros_definitions.hpp"
#include "kinetrace/publishing/ros_reader.hpp"
#include "publisher_fixture.hpp"

namespace kinetrace::publishing {
namespace {

using test::PublisherFixture;
using test::SampleResult;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

/// Keeps copies of all received data.
class Notebook final : public ResultListener {
 public:
  void receive(const ReceivedCamera& received) override { cameras.push_back(received); }
  void receive(const ReceivedObjects& received) override {
    ++object_messages;
    objects.insert(objects.end(), received.objects.begin(), received.objects.end());
  }
  void receive(const ReceivedHealth& received) override {
    healths.push_back(received.state);
    camera_state = received.camera;
    rig = received.rig;
    for (const ReceivedReason& reason : received.reasons) {
      reasons[std::string(reason.name)] = reason.count;
    }
    for (const ReceivedCounter& counter : received.counters) {
      counters[std::string(counter.name)] = counter.value;
    }
  }
  void receive(const ReceivedCalibration& received) override {
    device = received.device;
    calibrations.push_back(received.geometry);
  }

  std::vector<ReceivedCamera> cameras;  // Their device text is invalid by now.
  std::vector<ObjectResult> objects;
  int object_messages = 0;
  std::vector<HealthState> healths;
  std::string camera_state;
  std::map<std::string, std::uint64_t> reasons;
  std::map<std::string, std::uint64_t> counters;
  RigEstimate rig;
  std::string device;
  std::vector<StereoGeometry> calibrations;
};

/// Receives until `is_enough`, waiting as a program would.
template <typename Take>
bool take_until(Link& link, Take&& take, const std::function<bool()>& is_enough) {
  for (int i = 0; i < 100; ++i) {
    const Status taken = take();
    EXPECT_TRUE(taken) << taken.error().message;
    if (is_enough()) {
      return true;
    }
    link.wait(50'000'000);
  }
  return false;
}

class Readers : public ::testing::Test {
 protected:
  bool hear_until(const std::function<bool()>& is_enough) {
    return take_until(
        fixture_.publisher().link(), [this] { return reader_.take(notes_); }, is_enough);
  }

  PublisherFixture fixture_{{.device = "front"}};
  ResultReader reader_{fixture_.publisher().link()};
  Notebook notes_;
};

TEST_F(Readers, WhoComesLateHearsTheCalibrationAtOnce) {
  ASSERT_TRUE(hear_until([&] { return !notes_.calibrations.empty(); }));
  const StereoGeometry expected = SampleResult::geometry();
  EXPECT_EQ(notes_.device, "front");
  EXPECT_EQ(notes_.calibrations[0].width_px, expected.width_px);
  EXPECT_EQ(notes_.calibrations[0].height_px, expected.height_px);
  EXPECT_EQ(notes_.calibrations[0].fx_px, expected.fx_px);
  EXPECT_EQ(notes_.calibrations[0].cy_px, expected.cy_px);
  EXPECT_EQ(notes_.calibrations[0].baseline_m, expected.baseline_m);
}

TEST_F(Readers, PosesAndObjectsComeBackAsTheyWere) {
  ASSERT_TRUE(hear_until([&] { return !notes_.calibrations.empty(); }));
  fixture_.publish(SampleResult({.objects = 2}, 7));
  ASSERT_TRUE(hear_until([&] { return !notes_.cameras.empty() && notes_.object_messages > 0; }));
  const ReceivedCamera& camera = notes_.cameras[0];
  EXPECT_EQ(camera.frame_index, 7);
  EXPECT_EQ(camera.timestamp_ns, SampleResult::timestamp_ns(7));
  EXPECT_EQ(camera.handed_over_ns, PublisherFixture::kHandedOver_ns);
  EXPECT_EQ(camera.camera.status, BodyStatus::kTracked);
  const Se3 expected = SampleResult::T_world_cam(7);
  EXPECT_TRUE(camera.camera.T_world_cam.rotation.isApprox(expected.rotation, 1e-12));
  EXPECT_TRUE(camera.camera.T_world_cam.translation.isApprox(expected.translation, 1e-12));

  ASSERT_EQ(notes_.objects.size(), 2U);
  const ObjectResult object = SampleResult::object(2, 7);
  const ObjectResult& received = notes_.objects[1];
  EXPECT_EQ(received.track_id, 2U);
  EXPECT_EQ(received.class_id, object.class_id);
  EXPECT_EQ(received.status, object.status);
  EXPECT_EQ(received.moving, object.moving);
  EXPECT_TRUE(received.T_world_obj.translation.isApprox(object.T_world_obj.translation, 1e-12));
  EXPECT_TRUE(received.covariance.isApprox(object.covariance, 1e-6));
  EXPECT_TRUE(received.velocity_mps.isApprox(object.velocity_mps, 1e-6));
  EXPECT_TRUE(received.box.size_m.isApprox(object.box.size_m, 1e-6));
  EXPECT_NEAR(received.box.yaw_rad, object.box.yaw_rad, 1e-6);
  EXPECT_EQ(received.box_px.y1, object.box_px.y1);
  EXPECT_EQ(received.point_count, object.point_count);
}

TEST(ResultReader, HearsAllPiecesOfManyObjects) {
  PublisherFixture fixture({.piece_bytes = PublishConfig::kMinPieceBytes});
  Link& link = fixture.publisher().link();
  ResultReader reader(link);
  Notebook notes;
  const auto take = [&] { return reader.take(notes); };
  ASSERT_TRUE(take_until(link, take, [&] { return !notes.calibrations.empty(); }));
  fixture.publish(SampleResult({.objects = kMaxObjects}, 0));
  ASSERT_TRUE(take_until(link, take, [&] { return notes.objects.size() == kMaxObjects; }));
  EXPECT_GT(notes.object_messages, 3);
}

TEST_F(Readers, HealthComesWithReasonsAndCounts) {
  PublishedHealth health;
  health.state = HealthState::kDegraded;
  health.camera = "streaming";
  health.entries[static_cast<std::size_t>(HealthReason::kFramesLost)] = {HealthReason::kFramesLost, 3, 5, 9};
  health.counters.tracks_born = 17;
  health.rig.verdict = RigVerdict::kHolds;
  health.rig.correction.turn_rad.x() = 0.001;
  health.rig.windows = 9;
  fixture_.mailbox().offer_health(health);
  fixture_.serve();
  ASSERT_TRUE(hear_until([&] { return !notes_.healths.empty(); }));
  EXPECT_EQ(notes_.healths[0], HealthState::kDegraded);
  EXPECT_EQ(notes_.camera_state, "streaming");
  EXPECT_EQ(notes_.reasons, (std::map<std::string, std::uint64_t>{{"frames_lost", 3}}));
  EXPECT_EQ(notes_.counters.at("tracks_born"), 17U);
  EXPECT_EQ(notes_.rig.verdict, RigVerdict::kHolds);
  EXPECT_DOUBLE_EQ(notes_.rig.correction.turn_rad.x(), 0.001);
  EXPECT_EQ(notes_.rig.windows, 9U);
}

TEST_F(Readers, WaitReturnsWhenSomethingComesAndNotBefore) {
  ASSERT_TRUE(hear_until([&] { return !notes_.calibrations.empty(); }));
  Link& link = fixture_.publisher().link();
  const auto seconds_of_wait = [&link] {
    const auto begin = std::chrono::steady_clock::now();
    link.wait(400'000'000);
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  };
  EXPECT_GT(seconds_of_wait(), 0.35) << "nothing was sent";
  fixture_.publish(SampleResult({}, 1));
  EXPECT_LT(seconds_of_wait(), 0.35);
  ASSERT_TRUE(hear_until([&] { return notes_.cameras.size() == 1; }));
  link.wake();
  EXPECT_LT(seconds_of_wait(), 0.35);
  EXPECT_GT(seconds_of_wait(), 0.35) << "woken once";
}

/// A message's copy.
struct Kept {
  std::string topic;
  std::int64_t sent_ns = 0;
  std::string cdr;
};

class RosReaders : public ::testing::Test {
 protected:
  bool hear_until(const std::function<bool()>& is_enough) {
    const auto take = [this] {
      return reader_.take([this](const RosMessage& message) -> Status {
        kept_.push_back({reader_.topics()[message.topic].name, message.sent_ns,
                         std::string(reinterpret_cast<const char*>(message.cdr.data()), message.cdr.size())});
        return {};
      });
    };
    return take_until(fixture_.publisher().link(), take, is_enough);
  }
  [[nodiscard]] const Kept* find(const std::string& topic) const {
    const auto found = std::find_if(kept_.begin(), kept_.end(), [&](const Kept& k) { return k.topic == topic; });
    return found == kept_.end() ? nullptr : &*found;
  }

  PublisherFixture fixture_{{}};
  RosReader reader_{fixture_.publisher().link(), "kinetrace"};
  std::vector<Kept> kept_;
};

TEST_F(RosReaders, KnowEveryTopicWithItsTypeAndDefinition) {
  std::map<std::string, std::string> types;
  for (const RosTopicDescription& topic : reader_.topics()) {
    types[topic.name] = topic.type;
    EXPECT_THAT(topic.definition, HasSubstr("MSG: ")) << topic.name;
    EXPECT_THAT(topic.qos, HasSubstr(topic.name == "/tf_static" ? "durability: 1" : "durability: 2"));
  }
  EXPECT_EQ(types, (std::map<std::string, std::string>{{"/kinetrace/odometry", "nav_msgs/msg/Odometry"},
                                                       {"/kinetrace/detections", "vision_msgs/msg/Detection3DArray"},
                                                       {"/kinetrace/markers", "visualization_msgs/msg/MarkerArray"},
                                                       {"/kinetrace/trajectories", "geometry_msgs/msg/PoseArray"},
                                                       {"/kinetrace/points", "sensor_msgs/msg/PointCloud2"},
                                                       {"/kinetrace/fix", "sensor_msgs/msg/NavSatFix"},
                                                       {"/kinetrace/object_fixes", "sensor_msgs/msg/NavSatFix"},
                                                       {"/tf", "tf2_msgs/msg/TFMessage"},
                                                       {"/tf_static", "tf2_msgs/msg/TFMessage"},
                                                       {"/diagnostics", "diagnostic_msgs/msg/DiagnosticArray"}}));
}

TEST_F(RosReaders, HandOnTheBytesAsTheyTravelled) {
  ASSERT_TRUE(hear_until([&] { return find("/tf_static") != nullptr; })) << "kept for those who come late";
  fixture_.publish(SampleResult({}, 7));
  ASSERT_TRUE(hear_until([&] { return find("/kinetrace/odometry") != nullptr && find("/tf") != nullptr; }));
  const Kept& odometry = *find("/kinetrace/odometry");
  // XCDR1, little endian; a time, two strings, 2 covariances of 36, 7 + 6 numbers.
  EXPECT_EQ(odometry.cdr.substr(0, 2), std::string("\0\1", 2));
  EXPECT_GT(odometry.cdr.size(), 8 * (36 + 36 + 7 + 6));
  std::uint32_t length = 0;
  std::memcpy(&length, odometry.cdr.data() + 12, sizeof(length));
  ASSERT_EQ(length, 5U);
  EXPECT_EQ(odometry.cdr.substr(16, 4), "odom");
  EXPECT_GT(odometry.sent_ns, 1'600'000'000'000'000'000) << "the sender's clock";
}

TEST_F(RosReaders, EndWithTheErrorOfWhoTakes) {
  Status taken;
  ASSERT_TRUE(take_until(
      fixture_.publisher().link(),
      [&]() -> Status {
        taken = reader_.take([](const RosMessage&) -> Status { return fail(ErrorCode::kIo, "disk full"); });
        return {};
      },
      [&] { return !taken; }));
  EXPECT_EQ(taken.error().message, "disk full");
}

TEST(RosDefinitions, NameEveryTypeInThemOnceAndNoOther) {
  const std::string text = ros_definition("vision_msgs/msg/Detection3DArray");
  EXPECT_EQ(text.find("std_msgs/Header header\nvision_msgs/Detection3D[] detections\n===="), 0U);
  for (const char* type : {"std_msgs/Header", "builtin_interfaces/Time", "vision_msgs/ObjectHypothesisWithPose",
                           "geometry_msgs/PoseWithCovariance", "geometry_msgs/Quaternion", "geometry_msgs/Vector3"}) {
    const std::string heading = std::string("MSG: ") + type + "\n";
    const std::size_t at = text.find(heading);
    ASSERT_NE(at, std::string::npos) << type;
    EXPECT_EQ(text.find(heading, at + 1), std::string::npos) << type << " twice";
  }
  EXPECT_THAT(text, Not(HasSubstr("Odometry")));
  EXPECT_EQ(ros_definition("std_msgs/msg/String"), "");
}

TEST(Link, ThereIsOneAtATime) {
  PublishConfig config;
  config.domain = test::test_domain();
  const auto first = Link::create(config);
  ASSERT_TRUE(first) << first.error().message;
  EXPECT_EQ(Link::create(config).error().code, ErrorCode::kIllegalState);
}

TEST(Link, ThatHasNoInterfaceWaitsAndReadersHearNothing) {
  PublishConfig config;
  config.domain = test::test_domain();
  config.interface = "nowhere0";
  const auto link = Link::create(config);
  ASSERT_TRUE(link) << link.error().message;
  EXPECT_EQ((*link)->state(), LinkState::kWaiting);
  EXPECT_EQ((*link)->membership().number, 0U);
  EXPECT_THAT((*link)->take_notice().value_or(""), AllOf(HasSubstr("nowhere0"), HasSubstr("lo")));
  ResultReader reader(**link);
  Notebook notes;
  EXPECT_TRUE(reader.take(notes));
  (*link)->wait(1'000'000);
  (*link)->supervise(1'000'000'000);
  EXPECT_TRUE(reader.take(notes));
  EXPECT_TRUE(notes.calibrations.empty());
}

}  // namespace
}  // namespace kinetrace::publishing

// kinetrace map beside a live run, from outside: a publisher and a receiver in the test, the topics of ROS 2 read by
// their types alone.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <fstream>
#include <optional>
#include <random>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "kinetrace/geo/geodesy.hpp"
#include "message_reader.hpp"
#include "program.hpp"
#include "publisher_fixture.hpp"
#include "receiver.hpp"
#include "receiver_topic.hpp"
#include "temp_folder.hpp"

namespace kinetrace::test {
namespace {

using geo::Fix;
using geo::PathPose;
using geo::test::drive;
using geo::test::Receiver;
using nlohmann::json;
using ::testing::HasSubstr;
using NavSatFix = sensor_msgs_msg_dds__NavSatFix_;
using Transforms = tf2_msgs_msg_dds__TFMessage_;
using Diagnostics = diagnostic_msgs_msg_dds__DiagnosticArray_;

constexpr std::int64_t kClocks_ns = 4'000'000'000'000;  // System clock minus the camera's.
constexpr std::int64_t kLatency_ns = 40'000'000;
const Eigen::Vector3d kCar_cam(1.0, 0.5, 12.0);
constexpr double kDegree = M_PI / 180.0;

class LiveMap : public ::testing::Test {
 protected:
  LiveMap() {
    std::ofstream(network_) << "dds:\n  domain: " << fixture_.domain() << "\n  device: rig\n";
    std::mt19937 random(11);
    truth_ = {.T_map_world = geo::test::any_placement(random, 0.0),
              .time_offset_s = -static_cast<double>(kClocks_ns) * 1e-9,
              .noise_m = 0.02,
              .outlier_share = 0.1};
  }

  /// Drives along `shape`, twenty times as fast as in reality; ends early if `is_enough`.
  template <typename IsEnough>
  void play(const geo::test::PathShape& shape, IsEnough&& is_enough) {
    std::mt19937 random(12);
    const std::vector<PathPose> path = drive(shape);
    const std::vector<Fix> fixes = receive(path, truth_, random);
    std::size_t next = 0;
    for (std::size_t i = 0; i < path.size() && !is_enough(); ++i) {
      const std::int64_t now_ns = path[i].time_ns + kClocks_ns + kLatency_ns;
      for (; next < fixes.size() && fixes[next].time_ns < now_ns; ++next) {
        send(fixes[next]);
      }
      publish(path[i], static_cast<std::int64_t>(i));
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  }
  void publish(const PathPose& pose, std::int64_t frame) {
    SampleResult sample({.objects = 2}, frame);
    FrameEstimate& newest = sample.result.newest;
    newest.frame_index = frame;
    newest.timestamp_ns = pose.time_ns;
    newest.camera.T_world_cam = pose.T_world_cam;
    sample.objects[0].box.center_m = pose.T_world_cam * kCar_cam;
    sample.objects[1].status = BodyStatus::kLost;
    fixture_.mailbox().offer(sample.result, pose.time_ns + kClocks_ns + kLatency_ns);
    fixture_.serve();
  }
  void send(const Fix& fix) const {
    const geo::Geodetic place = frame_.to_geodetic(fix.enu_m);
    receiver_.send(fix.time_ns, 0, {place.latitude_deg, place.longitude_deg, place.height_m}, 0, 0.0);
  }
  [[nodiscard]] Program start(std::vector<std::string> more, const char* origin = "49.011,8.416,116.4") const {
    more.insert(more.begin(), {"map", "--reference", "navsatfix:/gps/fix", "--publish", network_, "--origin", origin});
    Program program(more);
    for (int i = 0; i < 500 && !receiver_.is_matched(); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    EXPECT_TRUE(receiver_.is_matched());
    return program;
  }
  /// Position of a fix on the map.
  [[nodiscard]] Eigen::Vector3d enu_m(const NavSatFix& fix) const {
    return frame_.to_enu({fix.latitude, fix.longitude, fix.altitude});
  }
  [[nodiscard]] static std::int64_t camera_ns(const builtin_interfaces_msg_dds__Time_& stamp) {
    return stamp.sec * 1'000'000'000LL + stamp.nanosec - kClocks_ns - kLatency_ns;
  }

  PublisherFixture fixture_{{.device = "rig"}};
  TempFolder folder_;
  std::string network_ = folder_.file("dds.yaml");
  geo::LocalFrame frame_ = geo::LocalFrame::at({49.011, 8.416, 116.4}).value();
  ReceiverTopic receiver_{fixture_.domain(), "rt/gps/fix", false};
  Receiver truth_;
  MessageReader<NavSatFix> camera_{fixture_.domain(), sensor_msgs_msg_dds__NavSatFix__desc, "rt/kinetrace/fix",
                                   DDS_DATA_REPRESENTATION_XCDR1};
  MessageReader<NavSatFix> objects_{fixture_.domain(), sensor_msgs_msg_dds__NavSatFix__desc,
                                    "rt/kinetrace/object_fixes", DDS_DATA_REPRESENTATION_XCDR1};
  MessageReader<Transforms> tf_{
      fixture_.domain(), tf2_msgs_msg_dds__TFMessage__desc, "rt/tf", DDS_DATA_REPRESENTATION_XCDR1, false, 2000};
  MessageReader<Diagnostics> diagnostics_{fixture_.domain(), diagnostic_msgs_msg_dds__DiagnosticArray__desc,
                                          "rt/diagnostics", DDS_DATA_REPRESENTATION_XCDR1};
};

double sigma_of(const NavSatFix& fix) {
  return std::sqrt(fix.position_covariance[0] + fix.position_covariance[4] + fix.position_covariance[8]);
}

std::vector<json> lines_of(const std::string& text) {
  std::vector<json> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    lines.push_back(json::parse(line));
  }
  return lines;
}

TEST_F(LiveMap, PublishesWhereCameraAndObjectsAreOnceTheAlignmentIsDetermined) {
  Program program = start({"--dof", "4", "--drift", "0.01", "--json"});
  const std::vector<PathPose> path = drive(geo::test::town());
  const auto pose_at = [&](std::int64_t time_ns) {
    const auto found = std::find_if(path.begin(), path.end(), [&](const PathPose& p) { return p.time_ns == time_ns; });
    return found == path.end() ? std::nullopt : std::optional(found->T_world_cam);
  };
  int cameras = 0;
  int cars = 0;
  int joins = 0;
  double error_m = 0.0;
  double sigma_m = 0.0;
  play(geo::test::town(), [&] {
    constexpr std::chrono::milliseconds kNow(0);
    for (const NavSatFix* fix = camera_.next(kNow); fix != nullptr; fix = camera_.next(kNow), ++cameras) {
      const auto T_world_cam = pose_at(camera_ns(fix->header.stamp));
      EXPECT_TRUE(T_world_cam) << "stamped as the odometry is";
      // The first alignments rest on as much of the drive as a busy machine has received by then.
      error_m = (enu_m(*fix) - truth_.T_map_world * T_world_cam->translation).norm();
      sigma_m = sigma_of(*fix);
      EXPECT_LT(error_m, 4.0 * sigma_m);
      EXPECT_STREQ(fix->header.frame_id, "camera_link");
      EXPECT_EQ(fix->position_covariance_type, 3);
    }
    for (const NavSatFix* fix = objects_.next(kNow); fix != nullptr; fix = objects_.next(kNow), ++cars) {
      const auto T_world_cam = pose_at(camera_ns(fix->header.stamp));
      EXPECT_TRUE(T_world_cam);
      EXPECT_LT((enu_m(*fix) - truth_.T_map_world * (*T_world_cam * kCar_cam)).norm(), 4.0 * sigma_of(*fix));
      EXPECT_STREQ(fix->header.frame_id, "object_1") << "not the lost one";
      EXPECT_GT(fix->position_covariance[0], 0.01) << "as uncertain as its box, too";
    }
    for (const Transforms* message = tf_.next(kNow); message != nullptr; message = tf_.next(kNow)) {
      const geometry_msgs_msg_dds__TransformStamped_& transform = message->transforms._buffer[0];
      if (std::string(transform.child_frame_id) == "odom") {
        ++joins;
        EXPECT_STREQ(transform.header.frame_id, "map");
        const auto& q = transform.transform.rotation;
        const Eigen::Quaterniond R_map_odom(q.w, q.x, q.y, q.z);
        // The x axis of odom is the world's z.
        const Eigen::Vector3d ahead = R_map_odom * Eigen::Vector3d::UnitX();
        EXPECT_LT(std::acos(std::min(1.0, ahead.dot(truth_.T_map_world.rotation.col(2)))), 1.0 * kDegree);
      }
    }
    return false;
  });
  program.send(SIGINT);
  const ProgramResult result = program.wait();
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_GT(cameras, 20);
  EXPECT_LT(error_m, 0.1) << "of the newest";
  EXPECT_LT(sigma_m, 0.3);
  EXPECT_GT(cars, 20);
  EXPECT_GT(joins, 20);
  const std::vector<json> lines = lines_of(result.out);
  ASSERT_FALSE(lines.empty());
  EXPECT_EQ(lines.back()["verdict"], "aligned");
  EXPECT_NEAR(lines.back()["time_offset_s"].get<double>(), truth_.time_offset_s, 0.02);
  EXPECT_EQ(lines.back()["reference"]["path"], "/gps/fix");
  EXPECT_EQ(lines.back()["map"]["origin"]["latitude"], 49.011);
}

TEST_F(LiveMap, PublishesNothingAndSaysWhyWhileMotionDoesNotDetermineIt) {
  Program program = start({"--dof", "6", "--time-offset", "-4000", "--max-time-offset", "0"});
  std::string said;
  play({}, [&] {  // A straight line.
    EXPECT_EQ(camera_.next(std::chrono::milliseconds(0)), nullptr);
    if (const Diagnostics* message = diagnostics_.next(std::chrono::milliseconds(0))) {
      const diagnostic_msgs_msg_dds__DiagnosticStatus_& status = message->status._buffer[0];
      if (std::string(status.name) == "kinetrace map") {
        EXPECT_EQ(status.level, 1);
        said = status.message;
      }
    }
    return false;
  });
  program.send(SIGINT);
  const ProgramResult result = program.wait();
  EXPECT_EQ(result.exit_code, kBadData) << result.err;
  EXPECT_THAT(result.err, HasSubstr("the rotation about the direction of travel"));
  EXPECT_THAT(result.out, HasSubstr("not aligned, nothing is published"));
  EXPECT_THAT(said, HasSubstr("the rotation about the direction of travel"));
  for (const Transforms* message = tf_.next(std::chrono::milliseconds(0)); message != nullptr;
       message = tf_.next(std::chrono::milliseconds(0))) {
    EXPECT_STRNE(message->transforms._buffer[0].header.frame_id, "map");
  }
}

TEST_F(LiveMap, AnotherRunBeginsAnew) {
  Program program = start({"--dof", "4"});
  bool is_aligned = false;
  play(geo::test::town(), [&] { return is_aligned = camera_.next(std::chrono::milliseconds(0)) != nullptr; });
  ASSERT_TRUE(is_aligned);
  // Frame 0 again: the world has a new origin, so that the alignment no longer holds.
  while (camera_.next(std::chrono::milliseconds(200)) != nullptr) {
  }
  std::vector<PathPose> path = drive(geo::test::town());
  for (std::size_t i = 0; i < 10; ++i) {
    path[i].time_ns += 1'000'000'000'000;
    publish(path[i], static_cast<std::int64_t>(i));
  }
  EXPECT_EQ(camera_.next(std::chrono::milliseconds(300)), nullptr);
  program.send(SIGTERM);
  EXPECT_EQ(program.wait().exit_code, 0);
}

TEST_F(LiveMap, RefusesAnOriginFarFromTheFirstFix) {
  Program program = start({"--seconds", "20"}, "50.5,8.416,116.4");
  // The program may match the receiver later than the receiver matches it.
  for (int i = 1; i <= 20; ++i) {
    send({.time_ns = i * 100'000'000LL, .enu_m = Eigen::Vector3d::Zero()});
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  expect_refusal(program.wait(), kUsage, "--origin lies 166 km from the fixes");
}

TEST_F(LiveMap, SaysWhatIsMissingOrWrong) {
  const auto map = [&](std::vector<std::string> more) {
    more.insert(more.begin(), "map");
    return run_kinetrace(more);
  };
  expect_refusal(map({"--reference", "navsatfix:/fix", "--publish", network_, "--seconds", "0.5", "--quiet"}), kIo,
                 "no pose of the camera has come yet");
  expect_refusal(map({folder_.path().string(), "--reference", "navsatfix:/fix"}), kUsage, "leave out the run folder");
  expect_refusal(map({"--reference", "navsatfix:fix"}), kUsage, "a topic of ROS 2 such as /fix");
  expect_refusal(map({"--reference", "navsatfix:/fix", "--publish", "/nowhere.yaml"}), kNoInput, "/nowhere.yaml");
  expect_refusal(map({"--reference", "navsatfix:/fix", "--origin", "91,0,0"}), kUsage, "");
  expect_refusal(map({"--reference", "nmea:log"}), kUsage, "RUN");
  std::ofstream(network_) << "dds:\n  native: false\n";
  expect_refusal(map({"--reference", "navsatfix:/fix", "--publish", network_}), kConfig, "dds.native");
}

}  // namespace
}  // namespace kinetrace::test

// Files of the recorder, read by the format's own library and decoded as ROS 2 does.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "kinetrace/publishing/ros_reader.hpp"
#include "kinetrace/recording/mcap_writer.hpp"
#include "publisher_fixture.hpp"
#include "temp_folder.hpp"

namespace kinetrace::test {
namespace {

using nlohmann::json;
using ::testing::SizeIs;

/// The npm library's output for a file, lines of JSON; fails if the library reports an error.
std::vector<json> decoded(const std::string& how, const std::filesystem::path& file) {
  const std::string command =
      "node " KINETRACE_MCAP_TOOLS "/decode.mjs --" + how + " '" + file.string() + "' 2>" + file.string() + ".err";
  std::string out;
  FILE* pipe = popen(command.c_str(), "r");
  std::array<char, 4096> buffer{};
  for (std::size_t count = 0; (count = std::fread(buffer.data(), 1, buffer.size(), pipe)) > 0;) {
    out.append(buffer.data(), count);
  }
  const int status = pclose(pipe);
  std::ostringstream complaint;
  complaint << std::ifstream(file.string() + ".err").rdbuf();
  EXPECT_EQ(status, 0) << complaint.str();
  std::vector<json> lines;
  std::istringstream in(out);
  for (std::string line; std::getline(in, line);) {
    lines.push_back(json::parse(line));
  }
  return lines;
}

/// Records a publisher's messages of some frames, as kinetrace monitor does.
class McapTools : public ::testing::Test {
 protected:
  static constexpr int kFrames = 3;
  static constexpr std::int64_t kFirstReceived_ns = 1'900'000'000'000'000'000;

  void SetUp() override {
    if (!std::filesystem::exists(KINETRACE_MCAP_TOOLS "/installed")) {
      GTEST_SKIP() << "the npm packages are not there: build the target kinetrace_mcap_tools with npm and a network";
    }
    PublisherFixture fixture({.device = "front"});
    publishing::RosReader reader(fixture.publisher().link(), "kinetrace");
    recording::McapWriter writer = recording::McapWriter::create(file_, "kinetrace test").value();
    std::vector<std::uint16_t> channels;
    for (const publishing::RosTopicDescription& topic : reader.topics()) {
      channels.push_back(
          writer.add_topic({topic.name, topic.type, topic.definition, {{"offered_qos_profiles", topic.qos}}}).value());
    }
    const auto take = [&] {
      return reader.take([&](const publishing::RosMessage& message) {
        ++received_[reader.topics()[message.topic].name];
        return writer.write(channels[message.topic], received_ns_ += 1'000'000, message.sent_ns, message.cdr);
      });
    };
    const auto take_until = [&](const char* topic, int count) {
      for (int i = 0; i < 100 && received_[topic] < count; ++i) {
        ASSERT_TRUE(take());
        fixture.publisher().link().wait(20'000'000);
      }
      ASSERT_GE(received_[topic], count) << topic;
    };
    take_until("/tf_static", 1);
    for (int frame = 0; frame < kFrames; ++frame) {
      publishing::PublishedHealth health;
      health.state = HealthState::kDegraded;
      health.camera = "streaming";
      fixture.mailbox().offer_health(health);
      fixture.publish(SampleResult({.objects = 3, .background_points = 100, .points_per_object = 20}, frame));
      take_until("/kinetrace/points", frame + 1);
    }
    fixture.mailbox().end_trajectories();
    fixture.serve();
    take_until("/kinetrace/trajectories", 3);
    take_until("/diagnostics", kFrames);
    ASSERT_TRUE(writer.finish());
  }

  TempFolder folder_;
  std::filesystem::path file_ = folder_.path() / "run.mcap";
  std::map<std::string, int> received_;
  std::int64_t received_ns_ = kFirstReceived_ns;
};

TEST_F(McapTools, DecodesEveryMessageByTheDefinitionInTheFile) {
  const std::vector<json> messages = decoded("indexed", file_);
  std::map<std::string, int> by_topic;
  std::map<std::string, json> first;
  for (const json& message : messages) {
    const auto topic = message.at("topic").get<std::string>();
    ++by_topic[topic];
    first.emplace(topic, message);
    EXPECT_TRUE(message.at("same").get<bool>()) << topic << " as " << message.at("type");
  }
  EXPECT_EQ(by_topic, received_);
  ASSERT_THAT(by_topic, SizeIs(8));

  const json& odometry = first["/kinetrace/odometry"].at("value");
  EXPECT_EQ(odometry.at("header").at("frame_id"), "odom");
  EXPECT_EQ(odometry.at("child_frame_id"), "camera_link");
  EXPECT_EQ(odometry.at("header").at("stamp").at("sec"), PublisherFixture::kHandedOver_ns / 1'000'000'000);
  EXPECT_NEAR(odometry.at("pose").at("pose").at("position").at("x").get<double>(),
              SampleResult::T_world_cam(0).translation.z(), 1e-12);
  EXPECT_THAT(odometry.at("pose").at("covariance"), SizeIs(36));

  const json& detections = first["/kinetrace/detections"].at("value").at("detections");
  ASSERT_THAT(detections, SizeIs(3));
  const ObjectResult object = SampleResult::object(2, 0);
  EXPECT_EQ(detections.at(1).at("id"), "2");
  EXPECT_EQ(detections.at(1).at("results").at(0).at("hypothesis").at("class_id"), "car");
  EXPECT_NEAR(detections.at(1).at("bbox").at("center").at("position").at("x").get<double>(), object.box.center_m.z(),
              1e-12);
  EXPECT_NEAR(detections.at(1).at("bbox").at("size").at("z").get<double>(), object.box.size_m.y(), 1e-12);

  EXPECT_EQ(first["/tf"].at("value").at("transforms").at(0).at("child_frame_id"), "camera_link");
  EXPECT_THAT(first["/tf_static"].at("value").at("transforms"), SizeIs(2));
  EXPECT_EQ(first["/kinetrace/markers"].at("value").at("markers").at(1).at("text"), "pedestrian 1");
  EXPECT_THAT(first["/kinetrace/trajectories"].at("value").at("poses"), SizeIs(kFrames));
  const json& points = first["/kinetrace/points"].at("value");
  EXPECT_EQ(points.at("width"), 160);
  EXPECT_THAT(points.at("data"), SizeIs(160 * 16));
  EXPECT_EQ(points.at("fields").at(3).at("name"), "track_id");
  const json& status = first["/diagnostics"].at("value").at("status").at(0);
  EXPECT_EQ(status.at("level"), 1);
  EXPECT_EQ(status.at("hardware_id"), "front");
}

TEST_F(McapTools, ReadsTimesAndSequenceNumbers) {
  std::map<std::string, int> next;
  std::int64_t last_ns = 0;
  for (const json& message : decoded("indexed", file_)) {
    EXPECT_EQ(message.at("sequence"), next[message.at("topic").get<std::string>()]++);
    const std::int64_t log_ns = std::stoll(message.at("log_time").get<std::string>());
    EXPECT_GT(log_ns, std::max(last_ns, kFirstReceived_ns));
    EXPECT_GT(std::stoll(message.at("publish_time").get<std::string>()), 1'600'000'000'000'000'000);
    last_ns = log_ns;
  }
  EXPECT_EQ(last_ns, received_ns_);
}

TEST_F(McapTools, ReadsAFileThatWasCutUpToItsLastWholeMessage) {
  const std::vector<json> all = decoded("stream", file_);
  const auto size = std::filesystem::file_size(file_);
  // Cuts at every tenth, hence in every part of a file.
  std::size_t before = 0;
  for (int tenths = 1; tenths < 10; ++tenths) {
    const std::filesystem::path cut = folder_.path() / ("cut_" + std::to_string(tenths) + ".mcap");
    std::filesystem::copy_file(file_, cut);
    std::filesystem::resize_file(cut, size * static_cast<std::uintmax_t>(tenths) / 10);
    const std::vector<json> some = decoded("stream", cut);
    ASSERT_LE(some.size(), all.size());
    EXPECT_GE(some.size(), before);
    EXPECT_TRUE(std::equal(some.begin(), some.end(), all.begin())) << tenths;
    before = some.size();
  }
  EXPECT_GT(before, all.size() / 2);
}

TEST_F(McapTools, NoticesADamagedMessage) {
  const auto size = std::filesystem::file_size(file_);
  std::fstream file(file_, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(static_cast<std::streamoff>(size / 3));
  file.put('\x5A');
  file.put('\xA5');
  file.close();
  EXPECT_NE(
      std::system(
          ("node " KINETRACE_MCAP_TOOLS "/decode.mjs --indexed '" + file_.string() + "' >/dev/null 2>&1").c_str()),
      0);
}

}  // namespace
}  // namespace kinetrace::test

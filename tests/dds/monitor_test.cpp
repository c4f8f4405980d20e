// kinetrace monitor, from outside, with a publisher in the test.
#include <atomic>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "kinetrace/core/quantiles.hpp"
#include "mcap_reader.hpp"
#include "program.hpp"
#include "publisher_fixture.hpp"
#include "temp_folder.hpp"

namespace kinetrace::test {
namespace {

using nlohmann::json;
using recording::test::read_mcap;
using recording::test::ReadMcap;
using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::UnorderedElementsAre;

/// Publishes at 50 Hz from a thread of its own.
class RunningPublisher {
 public:
  RunningPublisher() {
    publishing::PublishedHealth health;
    health.state = HealthState::kDegraded;
    health.camera = "streaming";
    health.entries[static_cast<std::size_t>(HealthReason::kFramesLost)] = {HealthReason::kFramesLost, 3, 5, 9};
    fixture_.mailbox().offer_health(health);
    thread_ = std::thread([this, health] {
      for (std::int64_t frame = 0; !ends_; ++frame) {
        fixture_.mailbox().offer_health(health);
        fixture_.publish(SampleResult({.objects = 2}, frame));
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
      }
    });
  }
  RunningPublisher(const RunningPublisher&) = delete;
  RunningPublisher& operator=(const RunningPublisher&) = delete;
  ~RunningPublisher() {
    ends_ = true;
    thread_.join();
  }
  [[nodiscard]] std::string domain() const { return std::to_string(fixture_.domain()); }

 private:
  PublisherFixture fixture_{{.device = "front"}};
  std::atomic<bool> ends_ = false;
  std::thread thread_;
};

class Monitor : public ::testing::Test {
 protected:
  [[nodiscard]] std::vector<std::string> arguments(std::vector<std::string> more) const {
    more.insert(more.begin(), {"monitor", "--domain", publisher_.domain()});
    return more;
  }
  [[nodiscard]] ProgramResult monitor(std::vector<std::string> more) const {
    return run_kinetrace(arguments(std::move(more)));
  }
  [[nodiscard]] std::filesystem::path file() const { return folder_.path() / "run.mcap"; }
  [[nodiscard]] std::string bytes() const {
    std::ostringstream content;
    content << std::ifstream(file(), std::ios::binary).rdbuf();
    return content.str();
  }
  /// Records until the file has this size.
  [[nodiscard]] ProgramResult record_until(std::uintmax_t size, int signal) const {
    Program program(arguments({"--quiet", "--record", file().string()}));
    const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    std::error_code missing;
    while ((std::filesystem::file_size(file(), missing) < size || missing) &&
           std::chrono::steady_clock::now() < give_up) {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    program.send(signal);
    return program.wait();
  }

  RunningPublisher publisher_;
  TempFolder folder_;
};

std::vector<json> lines_of(const std::string& text) {
  std::vector<json> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    lines.push_back(json::parse(line));
  }
  return lines;
}

TEST_F(Monitor, PrintsOneObjectOfJsonPerMessage) {
  const ProgramResult result = monitor({"--json", "--seconds", "5"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  std::map<std::string, json> first;
  std::vector<double> rates_hz;
  for (const json& line : lines_of(result.out)) {
    EXPECT_EQ(line.at("device"), "front");
    first.emplace(line.at("topic"), line);
    if (line.at("topic") == "rates") {
      rates_hz.push_back(line.at("camera_pose_hz").get<double>());
    }
  }
  ASSERT_EQ(first.size(), 5U) << result.out.substr(0, 2000);
  EXPECT_EQ(first["calibration"].at("width_px"), SampleResult::geometry().width_px) << "sent before we came";
  EXPECT_EQ(first["calibration"].at("baseline_m"), SampleResult::geometry().baseline_m);
  const json& pose = first["camera_pose"];
  const auto frame = pose.at("frame").get<std::int64_t>();
  EXPECT_EQ(pose.at("timestamp_ns"), SampleResult::timestamp_ns(frame));
  EXPECT_NEAR(pose.at("T_world_cam").at("position_m").at(2).get<double>(),
              SampleResult::T_world_cam(frame).translation.z(), 1e-9);
  EXPECT_EQ(pose.at("status"), "tracked");
  const json& objects = first["objects"].at("objects");
  ASSERT_EQ(objects.size(), 2U);
  EXPECT_EQ(objects.at(0).at("id"), 1);
  EXPECT_EQ(objects.at(0).at("class"), "pedestrian");
  EXPECT_EQ(objects.at(0).at("velocity_mps").at(2), 2.0);
  EXPECT_EQ(first["health"].at("state"), "degraded");
  EXPECT_EQ(first["health"].at("reasons").at(0).at("name"), "frames_lost");
  EXPECT_EQ(first["health"].at("counters").at("frames"), 0);
  // On a busy machine messages come late and then several at once.
  ASSERT_FALSE(rates_hz.empty());
  const double rate_hz = median(rates_hz);
  EXPECT_GT(rate_hz, 5.0);
  EXPECT_LT(rate_hz, 60.0) << "50 are sent";
}

TEST_F(Monitor, ShowsATableInPlainLinesWithoutATerminal) {
  const ProgramResult result = monitor({"--seconds", "4"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, AllOf(ContainsRegex("front: poses [0-9.]+/s, objects [0-9.]+/s"), HasSubstr("tracked"),
                                HasSubstr("health      degraded, camera streaming, frames_lost 3x"),
                                HasSubstr("calibration 1242x375 px, f 721.5 px, baseline 0.5400 m"),
                                ContainsRegex(" 1 pedestrian +tracked"), ContainsRegex(" 2 car +")));
  EXPECT_THAT(result.out, Not(HasSubstr("\033"))) << "no terminal, no escape sequences";
}

TEST_F(Monitor, AgeGrowsWithTheSourcesTime) {
  const ProgramResult result = monitor({"--seconds", "6"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  // The last column of object 1, in all tables.
  std::vector<double> ages;
  std::istringstream in(result.out);
  for (std::string line; std::getline(in, line);) {
    if (line.find(" 1 pedestrian") != std::string::npos) {
      ages.push_back(std::stod(line.substr(line.rfind(' '))));
    }
  }
  ASSERT_GE(ages.size(), 2U) << result.out;
  EXPECT_GT(ages.back(), ages.front());
}

TEST_F(Monitor, EndsAfterSoManyMessages) {
  const ProgramResult result = monitor({"--json", "--quiet", "--messages", "3"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(lines_of(result.out).size(), 3U) << result.out;
}

TEST_F(Monitor, SaysWhatToDoWhereNothingIsReceived) {
  const std::string silent = std::to_string(std::stoi(publisher_.domain()) < 200 ? 221 : 19);
  const ProgramResult result = run_kinetrace({"monitor", "--domain", silent, "--seconds", "0.5"});
  EXPECT_EQ(result.exit_code, 74);
  EXPECT_THAT(result.out, IsEmpty());
  EXPECT_THAT(result.err, AllOf(HasSubstr("nothing received from Kinetrace in domain " + silent + " on lo"),
                                HasSubstr("kinetrace run --publish"), HasSubstr("dds.interface")));
}

TEST_F(Monitor, NamesTheDeviceThatIsReceivedInstead) {
  const ProgramResult result = monitor({"--device", "rear", "--seconds", "4"});
  EXPECT_EQ(result.exit_code, 74);
  EXPECT_THAT(result.err, AllOf(HasSubstr("nothing seen device rear"), HasSubstr("but of front")));
}

TEST_F(Monitor, RecordsAnMcapFileThatCtrlCCloses) {
  const ProgramResult result = record_until(200'000, SIGINT);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const ReadMcap read = read_mcap(bytes());
  EXPECT_TRUE(read.is_finished);
  EXPECT_EQ(read.profile, "ros2");
  std::vector<std::string> topics;
  for (const auto& [id, channel] : read.channels) {
    topics.push_back(channel.topic);
  }
  EXPECT_THAT(topics, UnorderedElementsAre("/kinetrace/odometry", "/kinetrace/detections", "/kinetrace/trajectories",
                                           "/kinetrace/points", "/kinetrace/markers", "/kinetrace/fix",
                                           "/kinetrace/object_fixes", "/tf", "/tf_static", "/diagnostics"));
  EXPECT_EQ(read.index.size(), read.messages.size());
  std::map<std::string, int> by_topic;
  for (const auto& message : read.messages) {
    const auto& channel = read.channels.at(message.channel);
    ++by_topic[channel.topic];
    EXPECT_EQ(message.data.substr(0, 2), std::string("\0\1", 2)) << channel.topic << " is no XCDR1, little endian";
    EXPECT_THAT(channel.metadata.at("offered_qos_profiles"), HasSubstr("reliability: 1"));
    EXPECT_GE(message.log_time, message.publish_time);
  }
  EXPECT_GT(by_topic["/kinetrace/odometry"], 10);
  EXPECT_GT(by_topic["/kinetrace/detections"], 10);
  EXPECT_GT(by_topic["/kinetrace/points"], 10);
  EXPECT_GT(by_topic["/tf"], 10);
  EXPECT_EQ(by_topic["/tf_static"], 1) << "sent before we came";
  EXPECT_GE(by_topic["/diagnostics"], 1);
}

TEST_F(Monitor, LeavesAReadableFileWhenKilled) {
  const ProgramResult result = record_until(100'000, SIGKILL);
  EXPECT_EQ(result.exit_code, 128 + SIGKILL);
  const std::string content = bytes();
  const ReadMcap read = read_mcap(content);
  EXPECT_FALSE(read.is_finished);
  EXPECT_GT(read.messages.size(), 20U);
  // All but the last message or so.
  std::size_t bytes_in_messages = 0;
  for (const auto& message : read.messages) {
    bytes_in_messages += message.data.size();
  }
  EXPECT_GT(bytes_in_messages, content.size() / 2);
}

TEST_F(Monitor, DoesNotOverwriteFiles) {
  std::ofstream(file()) << "precious";
  const ProgramResult result = monitor({"--record", file().string(), "--seconds", "1"});
  EXPECT_EQ(result.exit_code, 73);
  EXPECT_THAT(result.err, HasSubstr("exists already"));
  EXPECT_EQ(bytes(), "precious");
}

TEST_F(Monitor, TakesTheFileThatARunPublishesBy) {
  const std::string config = folder_.file("dds.yaml");
  std::ofstream(config) << "dds:\n  domain: " << publisher_.domain() << "\n";
  const ProgramResult result = run_kinetrace({"monitor", "--publish", config, "--json", "--messages", "1"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(run_kinetrace({"monitor", "--publish", config + ".missing"}).exit_code, 66);
}

}  // namespace
}  // namespace kinetrace::test

// Fast DDS, without any code of Kinetrace, reads every topic of ROS 2.
#include <map>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "network.hpp"
#include "parts.hpp"

namespace kinetrace::test {
namespace {

class OtherVendor : public OwnNetworkTest {};

TEST_F(OtherVendor, ReadsEveryFieldOfEveryTopic) {
  const Process scene(scene_command());
  const Process reader(local_fast_reader_command());
  ASSERT_TRUE(reader.until(all_topics_have(1))) << reader.report() << reader.err() << scene.err();
  EXPECT_TRUE(reader.until(at_least("total", 200)));
  EXPECT_THAT(reader.report()["mistakes"], ::testing::IsEmpty());
}

TEST_F(OtherVendor, SeesTheNamesTypesAndEncodingThatRosKnows) {
  const std::map<std::string, std::string> types{
      {"rt/kinetrace/odometry", "nav_msgs::msg::dds_::Odometry_"},
      {"rt/kinetrace/detections", "vision_msgs::msg::dds_::Detection3DArray_"},
      {"rt/kinetrace/markers", "visualization_msgs::msg::dds_::MarkerArray_"},
      {"rt/kinetrace/trajectories", "geometry_msgs::msg::dds_::PoseArray_"},
      {"rt/kinetrace/points", "sensor_msgs::msg::dds_::PointCloud2_"},
      {"rt/tf", "tf2_msgs::msg::dds_::TFMessage_"},
      {"rt/tf_static", "tf2_msgs::msg::dds_::TFMessage_"},
      {"rt/diagnostics", "diagnostic_msgs::msg::dds_::DiagnosticArray_"}};
  const Process scene(scene_command({"dds.native=false"}));
  const Process reader(local_fast_reader_command());
  ASSERT_TRUE(reader.until([&](const nlohmann::json& report) { return report["writers"].size() >= types.size(); }))
      << reader.report();
  const nlohmann::json writers = reader.report()["writers"];
  EXPECT_EQ(writers.size(), types.size());
  for (const auto& [topic, type] : types) {
    ASSERT_TRUE(writers.contains(topic)) << topic;
    EXPECT_EQ(writers[topic]["type"], type);
    EXPECT_EQ(writers[topic]["reliable"], true);
    // None named means the first version of the encoding, XCDR1, which has number 0.
    const nlohmann::json encodings = writers[topic]["encodings"];
    EXPECT_TRUE(encodings.empty() || encodings == nlohmann::json{0}) << topic << encodings;
  }
}

TEST_F(OtherVendor, GetsWhatIsKeptHoweverLateItComes) {
  const Process scene(scene_command());
  ASSERT_TRUE(scene.until(at_least("offered", 100)));
  const Process late(local_fast_reader_command());
  EXPECT_TRUE(late.until([](const nlohmann::json& report) { return report["samples"]["rt/tf_static"] == 1; }))
      << late.report();
}

TEST_F(OtherVendor, HearsNothingFromAnotherDomain) {
  const Process elsewhere(scene_command({"dds.domain=7"}));
  const Process reader(local_fast_reader_command());
  ASSERT_TRUE(elsewhere.until(at_least("offered", 50)));
  // After data of its own domain, data of the other domain would have arrived, too.
  const Process scene(scene_command({"dds.ros2.prefix=own"}));
  ASSERT_TRUE(reader.until([](const nlohmann::json& report) { return report["samples"]["rt/tf"] >= 50; }));
  EXPECT_FALSE(reader.report()["writers"].contains("rt/kinetrace/odometry")) << reader.report();
}

}  // namespace
}  // namespace kinetrace::test

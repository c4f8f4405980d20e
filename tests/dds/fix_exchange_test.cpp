// Fixes of ROS 2 receivers in, geodetic positions to ROS 2 out.
#include "kinetrace/publishing/fix_exchange.hpp"

#include <chrono>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "message_reader.hpp"
#include "receiver_topic.hpp"
#include "ros2.h"
#include "test_domain.hpp"

namespace kinetrace::publishing {
namespace {

using test::MessageReader;
using test::ReceiverTopic;

constexpr std::int64_t kStamp_ns = 1'800'000'000'250'000'000;

class FixExchange : public ::testing::Test {
 protected:
  void SetUp() override {
    config_.domain = test::test_domain();
    link_ = Link::create(config_).value();
  }
  template <typename T>
  [[nodiscard]] MessageReader<T> reader(const dds_topic_descriptor_t& type, const char* topic) const {
    return MessageReader<T>(config_.domain, type, topic, DDS_DATA_REPRESENTATION_XCDR1);
  }

  PublishConfig config_;
  std::unique_ptr<Link> link_;
};

TEST_F(FixExchange, ReadsReceiversOfBothKinds) {
  for (const bool reliable : {true, false}) {
    FixReader reader(*link_, "/gps/fix");
    const ReceiverTopic receiver(config_.domain, "rt/gps/fix", reliable);
    std::vector<NavSatFix> received;
    const auto take = [&] { ASSERT_TRUE(reader.take([&](const NavSatFix& fix) { received.push_back(fix); })); };
    for (int i = 0; i < 100 && reader.senders() == 0; ++i) {
      take();
      link_->wait(20'000'000);
    }
    for (int i = 0; i < 100 && received.size() < 2; ++i) {
      receiver.send(kStamp_ns, -1, {1.0, 2.0, std::nan("")}, 0, 0.0);
      receiver.send(kStamp_ns, 2, {49.5, -8.25, 116.0}, 2, 4.0);
      link_->wait(20'000'000);
      take();
    }
    ASSERT_GE(received.size(), 2U) << (reliable ? "reliable" : "best effort");
    EXPECT_FALSE(received[0].has_fix);
    EXPECT_FALSE(received[0].covariance_known);
    EXPECT_TRUE(std::isnan(received[0].height_m));
    EXPECT_TRUE(received[1].has_fix);
    EXPECT_EQ(received[1].stamp_ns, kStamp_ns);
    EXPECT_EQ(received[1].latitude_deg, 49.5);
    EXPECT_EQ(received[1].longitude_deg, -8.25);
    EXPECT_EQ(received[1].height_m, 116.0);
    EXPECT_TRUE(received[1].covariance_known);
    EXPECT_EQ(received[1].covariance_m2(0, 0), 4.0);
    EXPECT_EQ(received[1].covariance_m2(0, 1), 1.0) << "row by row";
    EXPECT_EQ(received[1].covariance_m2(1, 0), 2.0);
  }
}

TEST_F(FixExchange, SendsPlacesWithTheFrameOfWhatIsThere) {
  MapSender sender(*link_, config_);
  auto camera = reader<sensor_msgs_msg_dds__NavSatFix_>(sensor_msgs_msg_dds__NavSatFix__desc, "rt/kinetrace/fix");
  auto objects =
      reader<sensor_msgs_msg_dds__NavSatFix_>(sensor_msgs_msg_dds__NavSatFix__desc, "rt/kinetrace/object_fixes");
  EXPECT_STREQ(sensor_msgs_msg_dds__NavSatFix__desc.m_typename, "sensor_msgs::msg::dds_::NavSatFix_");
  NavSatFix fix{.stamp_ns = kStamp_ns,
                .frame = "",
                .has_fix = true,
                .latitude_deg = 49.0,
                .longitude_deg = 8.4,
                .height_m = 116.4};
  fix.covariance_known = true;
  fix.covariance_m2 << 4, 1, 0, 1, 9, 0, 0, 0, 16;
  const sensor_msgs_msg_dds__NavSatFix_* message = nullptr;
  for (int i = 0; i < 100 && message == nullptr; ++i) {
    ASSERT_TRUE(sender.supervise(i * 1'000'000'000LL));
    sender.send_camera(fix);
    message = camera.next(std::chrono::milliseconds(20));
  }
  ASSERT_NE(message, nullptr);
  EXPECT_STREQ(message->header.frame_id, "camera_link");
  EXPECT_EQ(message->header.stamp.sec, 1'800'000'000);
  EXPECT_EQ(message->header.stamp.nanosec, 250'000'000U);
  EXPECT_EQ(message->status.status, 0);
  EXPECT_EQ(message->latitude, 49.0);
  EXPECT_EQ(message->longitude, 8.4);
  EXPECT_EQ(message->altitude, 116.4);
  EXPECT_EQ(message->position_covariance[1], 1.0);
  EXPECT_EQ(message->position_covariance[8], 16.0);
  EXPECT_EQ(message->position_covariance_type, 3);

  sender.send_object(4'000'000'000U, fix);
  const sensor_msgs_msg_dds__NavSatFix_* object = objects.next();
  ASSERT_NE(object, nullptr);
  EXPECT_STREQ(object->header.frame_id, "object_4000000000");
}

TEST_F(FixExchange, MapAndOdomAreJoinedByTf) {
  MapSender sender(*link_, config_);
  auto tf = reader<tf2_msgs_msg_dds__TFMessage_>(tf2_msgs_msg_dds__TFMessage__desc, "rt/tf");
  // The first camera looks west from 10 m east, 20 m north, 3 m up: its right is north, its down is down.
  Se3 T_map_world{Eigen::Matrix3d::Zero(), {10.0, 20.0, 3.0}};
  T_map_world.rotation << 0, 0, -1, 1, 0, 0, 0, -1, 0;
  const tf2_msgs_msg_dds__TFMessage_* message = nullptr;
  for (int i = 0; i < 100 && message == nullptr; ++i) {
    ASSERT_TRUE(sender.supervise(i * 1'000'000'000LL));
    sender.send_transform(kStamp_ns, T_map_world);
    message = tf.next(std::chrono::milliseconds(20));
  }
  ASSERT_NE(message, nullptr);
  ASSERT_EQ(message->transforms._length, 1U);
  const geometry_msgs_msg_dds__TransformStamped_& transform = message->transforms._buffer[0];
  EXPECT_STREQ(transform.header.frame_id, "map");
  EXPECT_STREQ(transform.child_frame_id, "odom");
  EXPECT_EQ(transform.transform.translation.y, 20.0);
  const auto& q = transform.transform.rotation;
  const Eigen::Quaterniond R_map_odom(q.w, q.x, q.y, q.z);
  EXPECT_TRUE((R_map_odom * Eigen::Vector3d::UnitX()).isApprox(-Eigen::Vector3d::UnitX())) << "ahead is west";
  EXPECT_TRUE((R_map_odom * Eigen::Vector3d::UnitZ()).isApprox(Eigen::Vector3d::UnitZ())) << "up is up";
}

TEST_F(FixExchange, DiagnosticsSayWhyNothingIsPublished) {
  MapSender sender(*link_, config_);
  auto diagnostics = reader<diagnostic_msgs_msg_dds__DiagnosticArray_>(diagnostic_msgs_msg_dds__DiagnosticArray__desc,
                                                                       "rt/diagnostics");
  const diagnostic_msgs_msg_dds__DiagnosticArray_* message = nullptr;
  for (int i = 0; i < 100 && message == nullptr; ++i) {
    ASSERT_TRUE(sender.supervise(i * 1'000'000'000LL));
    sender.send({.is_aligned = false, .message = "the path is a straight line", .fixes = 30, .inliers = 29}, kStamp_ns);
    message = diagnostics.next(std::chrono::milliseconds(20));
  }
  ASSERT_NE(message, nullptr);
  const diagnostic_msgs_msg_dds__DiagnosticStatus_& status = message->status._buffer[0];
  EXPECT_EQ(status.level, 1);
  EXPECT_STREQ(status.name, "kinetrace map");
  EXPECT_STREQ(status.message, "the path is a straight line");
  ASSERT_EQ(status.values._length, 3U);
  EXPECT_STREQ(status.values._buffer[1].value, "29");
}

}  // namespace
}  // namespace kinetrace::publishing

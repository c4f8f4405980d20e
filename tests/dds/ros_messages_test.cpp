// ROS 2 topics, as read: axes of REP 103, frames of REP 105.
#include <cmath>
#include <cstring>
#include <numbers>
#include <set>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "message_reader.hpp"
#include "publisher_fixture.hpp"
#include "ros2.h"

namespace kinetrace::publishing {
namespace {

using test::MessageReader;
using test::PublisherFixture;
using test::SampleResult;

template <typename T>
class RosReader : public MessageReader<T> {
 public:
  RosReader(const PublisherFixture& fixture, const dds_topic_descriptor_t& type, const char* topic,
            bool gets_kept = false)
      : MessageReader<T>(fixture.domain(), type, topic, DDS_DATA_REPRESENTATION_XCDR1, gets_kept) {}
};

Eigen::Vector3d turned(const geometry_msgs_msg_dds__Quaternion_& q, const Eigen::Vector3d& v) {
  return Eigen::Quaterniond(q.w, q.x, q.y, q.z) * v;
}

TEST(RosMessages, TypesHaveTheNamesThatRosKnows) {
  EXPECT_STREQ(nav_msgs_msg_dds__Odometry__desc.m_typename, "nav_msgs::msg::dds_::Odometry_");
  EXPECT_STREQ(tf2_msgs_msg_dds__TFMessage__desc.m_typename, "tf2_msgs::msg::dds_::TFMessage_");
  EXPECT_STREQ(vision_msgs_msg_dds__Detection3DArray__desc.m_typename, "vision_msgs::msg::dds_::Detection3DArray_");
  EXPECT_STREQ(visualization_msgs_msg_dds__MarkerArray__desc.m_typename, "visualization_msgs::msg::dds_::MarkerArray_");
  EXPECT_STREQ(geometry_msgs_msg_dds__PoseArray__desc.m_typename, "geometry_msgs::msg::dds_::PoseArray_");
  EXPECT_STREQ(sensor_msgs_msg_dds__PointCloud2__desc.m_typename, "sensor_msgs::msg::dds_::PointCloud2_");
  EXPECT_STREQ(diagnostic_msgs_msg_dds__DiagnosticArray__desc.m_typename,
               "diagnostic_msgs::msg::dds_::DiagnosticArray_");
}

TEST(RosMessages, OdometryHasTheAxesOfRos) {
  PublisherFixture fixture({});
  RosReader<nav_msgs_msg_dds__Odometry_> reader(fixture, nav_msgs_msg_dds__Odometry__desc, "rt/kinetrace/odometry");
  fixture.publish(SampleResult({}, 30));
  ASSERT_NE(reader.next(), nullptr);
  fixture.publish(SampleResult({}, 31));
  const nav_msgs_msg_dds__Odometry_* message = reader.next();
  ASSERT_NE(message, nullptr);
  EXPECT_STREQ(message->header.frame_id, "odom");
  EXPECT_STREQ(message->child_frame_id, "camera_link");
  EXPECT_EQ(message->header.stamp.sec, 1'800'000'000) << "the system's clock by default";
  // In our axes: 0.1 m right, 0.2 m up, and ahead.
  const auto& p = message->pose.pose.position;
  EXPECT_NEAR(p.x, SampleResult::kSpeed_mps * 31 / 30.0, 1e-6);
  EXPECT_NEAR(p.y, -0.1, 1e-12);
  EXPECT_NEAR(p.z, 0.2, 1e-12);
  // A right turn about our down axis is a negative angle about up.
  const Eigen::Vector3d ahead = turned(message->pose.pose.orientation, Eigen::Vector3d::UnitX());
  EXPECT_NEAR(std::atan2(ahead.y(), ahead.x()), -SampleResult::kTurn_radps * 31 / 30.0, 1e-6);
  const auto& twist = message->twist.twist;
  EXPECT_NEAR(std::hypot(twist.linear.x, twist.linear.y), SampleResult::kSpeed_mps, 1e-6);
  EXPECT_NEAR(twist.angular.z, -SampleResult::kTurn_radps, 1e-6);
  EXPECT_DOUBLE_EQ(message->pose.covariance[0], 1e-4);
  EXPECT_GT(message->twist.covariance[0], 0.0);
  EXPECT_LT(message->twist.covariance[0], 1.0);
}

TEST(RosMessages, StampsAreTheSourcesIfAskedFor) {
  PublishConfig config;
  config.ros2.stamps = RosStamps::kSource;
  PublisherFixture fixture(config);
  RosReader<nav_msgs_msg_dds__Odometry_> reader(fixture, nav_msgs_msg_dds__Odometry__desc, "rt/kinetrace/odometry");
  fixture.publish(SampleResult({}, 3));
  const nav_msgs_msg_dds__Odometry_* message = reader.next();
  ASSERT_NE(message, nullptr);
  EXPECT_EQ(message->header.stamp.sec, 1'700'000'000);
  EXPECT_EQ(message->header.stamp.nanosec, 99'999'999U);
}

TEST(RosMessages, ALostCameraHasNoOdometry) {
  PublisherFixture fixture({});
  RosReader<nav_msgs_msg_dds__Odometry_> reader(fixture, nav_msgs_msg_dds__Odometry__desc, "rt/kinetrace/odometry");
  SampleResult sample({}, 3);
  sample.result.newest.camera.status = BodyStatus::kLost;
  fixture.publish(sample);
  EXPECT_EQ(reader.next(std::chrono::milliseconds(100)), nullptr);
}

TEST(RosMessages, FramesFormOneTree) {
  PublisherFixture fixture({});
  RosReader<tf2_msgs_msg_dds__TFMessage_> kept(fixture, tf2_msgs_msg_dds__TFMessage__desc, "rt/tf_static", true);
  const tf2_msgs_msg_dds__TFMessage_* fixed = kept.next();
  ASSERT_NE(fixed, nullptr);
  ASSERT_EQ(fixed->transforms._length, 2U);
  const auto& left = fixed->transforms._buffer[0];
  EXPECT_STREQ(left.header.frame_id, "camera_link");
  EXPECT_STREQ(left.child_frame_id, "camera_left_optical_frame");
  EXPECT_TRUE(turned(left.transform.rotation, Eigen::Vector3d::UnitZ()).isApprox(Eigen::Vector3d::UnitX()))
      << "the optical axis points ahead";
  const auto& right = fixed->transforms._buffer[1];
  EXPECT_STREQ(right.header.frame_id, "camera_left_optical_frame");
  EXPECT_DOUBLE_EQ(right.transform.translation.x, 0.54);

  RosReader<tf2_msgs_msg_dds__TFMessage_> reader(fixture, tf2_msgs_msg_dds__TFMessage__desc, "rt/tf");
  fixture.publish(SampleResult({}, 30));
  const tf2_msgs_msg_dds__TFMessage_* moving = reader.next();
  ASSERT_NE(moving, nullptr);
  ASSERT_EQ(moving->transforms._length, 1U);
  EXPECT_STREQ(moving->transforms._buffer[0].header.frame_id, "odom");
  EXPECT_STREQ(moving->transforms._buffer[0].child_frame_id, "camera_link");
  EXPECT_NEAR(moving->transforms._buffer[0].transform.translation.x, 3.0, 1e-6);
}

TEST(RosMessages, DetectionsAreUprightBoxesWithAnId) {
  PublisherFixture fixture({});
  RosReader<vision_msgs_msg_dds__Detection3DArray_> reader(fixture, vision_msgs_msg_dds__Detection3DArray__desc,
                                                           "rt/kinetrace/detections");
  SampleResult sample({.objects = 3}, 0);
  sample.objects[2].status = BodyStatus::kLost;
  fixture.publish(sample);
  const vision_msgs_msg_dds__Detection3DArray_* message = reader.next();
  ASSERT_NE(message, nullptr);
  ASSERT_EQ(message->detections._length, 2U) << "without the lost one";
  const vision_msgs_msg_dds__Detection3D_& detection = message->detections._buffer[0];
  const ObjectResult expected = SampleResult::object(1, 0);
  EXPECT_STREQ(detection.id, "1");
  EXPECT_STREQ(detection.header.frame_id, "odom");
  ASSERT_EQ(detection.results._length, 1U);
  EXPECT_STREQ(detection.results._buffer[0].hypothesis.class_id, "pedestrian");
  EXPECT_DOUBLE_EQ(detection.results._buffer[0].hypothesis.score, 1.0);
  EXPECT_DOUBLE_EQ(detection.bbox.center.position.x, expected.box.center_m.z());
  EXPECT_DOUBLE_EQ(detection.bbox.center.position.y, -expected.box.center_m.x());
  EXPECT_DOUBLE_EQ(detection.bbox.center.position.z, -expected.box.center_m.y());
  EXPECT_DOUBLE_EQ(detection.bbox.size.x, 4.0) << "length";
  EXPECT_DOUBLE_EQ(detection.bbox.size.y, 1.8) << "width";
  EXPECT_DOUBLE_EQ(detection.bbox.size.z, 1.5) << "height";
  // The length, (cos yaw, 0, -sin yaw) in our axes.
  const Eigen::Vector3d along = turned(detection.bbox.center.orientation, Eigen::Vector3d::UnitX());
  EXPECT_NEAR(along.x(), -std::sin(-1.3), 1e-12);
  EXPECT_NEAR(along.y(), -std::cos(-1.3), 1e-12);
  EXPECT_NEAR(along.z(), 0.0, 1e-12);
  // The hypothesis has the box's uncertainty: along its length, across, down, and about up.
  const auto& hypothesis = detection.results._buffer[0].pose;
  EXPECT_EQ(hypothesis.pose.position.x, detection.bbox.center.position.x);
  EXPECT_EQ(hypothesis.pose.orientation.z, detection.bbox.center.orientation.z);
  const Eigen::Map<const Matrix6d> covariance(hypothesis.covariance);
  const Eigen::Vector3d left = turned(detection.bbox.center.orientation, Eigen::Vector3d::UnitY());
  const auto position = covariance.topLeftCorner<3, 3>();
  EXPECT_NEAR(along.dot(position * along), 0.25, 1e-12);
  EXPECT_NEAR(left.dot(position * left), 0.04, 1e-12);
  EXPECT_NEAR(position(2, 2), 0.01, 1e-12);
  EXPECT_NEAR(covariance(5, 5), 0.0025, 1e-12) << "about up";
}

TEST(RosMessages, ManyDetectionsComeInSeveralMessagesOfOneStamp) {
  PublisherFixture fixture({});
  RosReader<vision_msgs_msg_dds__Detection3DArray_> reader(fixture, vision_msgs_msg_dds__Detection3DArray__desc,
                                                           "rt/kinetrace/detections");
  fixture.publish(SampleResult({.objects = kMaxObjects}, 0));
  std::set<std::string> ids;
  std::uint32_t largest = 0;
  while (ids.size() < kMaxObjects) {
    const vision_msgs_msg_dds__Detection3DArray_* message = reader.next();
    ASSERT_NE(message, nullptr);
    largest = std::max(largest, message->detections._length);
    for (std::uint32_t i = 0; i < message->detections._length; ++i) {
      ids.insert(message->detections._buffer[i].id);
    }
  }
  EXPECT_LT(largest, 40U) << "of about 500 bytes each, in 16 kB";
}

TEST(RosMessages, MarkersAreABoxANameAndTheVelocityOfWhatMoves) {
  PublisherFixture fixture({});
  RosReader<visualization_msgs_msg_dds__MarkerArray_> reader(fixture, visualization_msgs_msg_dds__MarkerArray__desc,
                                                             "rt/kinetrace/markers");
  fixture.publish(SampleResult({.objects = 2}, 0));
  const visualization_msgs_msg_dds__MarkerArray_* message = reader.next();
  ASSERT_NE(message, nullptr);
  ASSERT_EQ(message->markers._length, 5U) << "the second object stands";
  const visualization_msgs_msg_dds__Marker_* markers = message->markers._buffer;
  EXPECT_STREQ(markers[0].ns, "box");
  EXPECT_EQ(markers[0].type, 1);
  EXPECT_EQ(markers[0].id, 1);
  EXPECT_DOUBLE_EQ(markers[0].scale.x, 4.0);
  EXPECT_EQ(markers[0].lifetime.sec, 1);
  EXPECT_STREQ(markers[1].text, "pedestrian 1");
  EXPECT_STREQ(markers[2].ns, "velocity");
  ASSERT_EQ(markers[2].points._length, 2U);
  EXPECT_NEAR(markers[2].points._buffer[1].x - markers[2].points._buffer[0].x, 2.0, 1e-12) << "ahead";
  EXPECT_NEAR(markers[2].points._buffer[1].y - markers[2].points._buffer[0].y, -0.5, 1e-12) << "to the right";
  EXPECT_STREQ(markers[4].text, "car 2");
}

TEST(RosMessages, ACloudIsThinnedToOnePiece) {
  PublisherFixture fixture({});
  RosReader<sensor_msgs_msg_dds__PointCloud2_> reader(fixture, sensor_msgs_msg_dds__PointCloud2__desc,
                                                      "rt/kinetrace/points");
  fixture.publish(SampleResult({.objects = 0, .background_points = 2000}, 0));
  const sensor_msgs_msg_dds__PointCloud2_* message = reader.next();
  ASSERT_NE(message, nullptr);
  EXPECT_EQ(message->height, 1U);
  EXPECT_GT(message->width, 900U);
  EXPECT_LE(message->width, 1000U);
  EXPECT_EQ(message->point_step, 16U);
  EXPECT_EQ(message->row_step, message->width * 16);
  ASSERT_EQ(message->data._length, message->row_step);
  ASSERT_EQ(message->fields._length, 4U);
  EXPECT_STREQ(message->fields._buffer[3].name, "track_id");
  // The last point is kept, with its position: ours are (x, y, z) = (.1 i, -.01 i, 1).
  std::array<float, 3> last{};
  std::memcpy(last.data(), message->data._buffer + message->data._length - 16, sizeof(last));
  EXPECT_THAT(last, testing::ElementsAre(testing::FloatEq(1.0F), testing::FloatEq(-0.1F * 1999),
                                         testing::FloatEq(0.01F * 1999)));
}

TEST(RosMessages, ATrajectoryIsAnArrayOfPoses) {
  PublisherFixture fixture({});
  RosReader<geometry_msgs_msg_dds__PoseArray_> reader(fixture, geometry_msgs_msg_dds__PoseArray__desc,
                                                      "rt/kinetrace/trajectories");
  fixture.publish(SampleResult({.objects = 1}, 0));
  fixture.publish(SampleResult({.objects = 1}, 1));
  fixture.mailbox().end_trajectories();
  fixture.serve();
  const geometry_msgs_msg_dds__PoseArray_* message = reader.next();
  ASSERT_NE(message, nullptr);
  ASSERT_EQ(message->poses._length, 2U);
  const Eigen::Vector3d expected = SampleResult::object(1, 1).T_world_obj.translation;
  EXPECT_DOUBLE_EQ(message->poses._buffer[1].position.x, expected.z());
  EXPECT_DOUBLE_EQ(message->poses._buffer[1].position.y, -expected.x());
}

TEST(RosMessages, DiagnosticsTellHowItIs) {
  PublisherFixture fixture({.device = "front"});
  RosReader<diagnostic_msgs_msg_dds__DiagnosticArray_> reader(fixture, diagnostic_msgs_msg_dds__DiagnosticArray__desc,
                                                              "rt/diagnostics");
  PublishedHealth health;
  health.state = HealthState::kLost;
  health.camera = "lost";
  health.entries[static_cast<std::size_t>(HealthReason::kCameraLost)] = {HealthReason::kCameraLost, 1, 5, 5};
  fixture.mailbox().offer_health(health);
  fixture.serve();
  const diagnostic_msgs_msg_dds__DiagnosticArray_* message = reader.next();
  ASSERT_NE(message, nullptr);
  ASSERT_EQ(message->status._length, 1U);
  const diagnostic_msgs_msg_dds__DiagnosticStatus_& status = message->status._buffer[0];
  EXPECT_EQ(status.level, 2);
  EXPECT_STREQ(status.hardware_id, "front");
  EXPECT_STREQ(status.message, "lost");
  ASSERT_GT(status.values._length, 2U);
  EXPECT_STREQ(status.values._buffer[0].key, "camera");
  EXPECT_STREQ(status.values._buffer[1].key, "camera_lost");
  EXPECT_STREQ(status.values._buffer[1].value, "1");
}

TEST(RosMessages, TopicsGoWithoutAPrefixToo) {
  PublishConfig config;
  config.ros2.prefix = "";
  PublisherFixture fixture(config);
  const RosReader<nav_msgs_msg_dds__Odometry_> reader(fixture, nav_msgs_msg_dds__Odometry__desc, "rt/odometry");
  EXPECT_TRUE(reader.is_matched());
}

TEST(RosMessages, NothingOfRosIsThereWhenItIsOff) {
  PublishConfig config;
  config.ros2.enabled = false;
  PublisherFixture fixture(config);
  const RosReader<nav_msgs_msg_dds__Odometry_> reader(fixture, nav_msgs_msg_dds__Odometry__desc,
                                                      "rt/kinetrace/odometry");
  EXPECT_FALSE(reader.is_matched());
}

}  // namespace
}  // namespace kinetrace::publishing

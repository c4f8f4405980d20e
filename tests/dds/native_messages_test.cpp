// Native topics, as read.
#include <cmath>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetrace.h"
#include "kinetrace/publishing/topics.hpp"
#include "message_reader.hpp"
#include "publisher_fixture.hpp"

namespace kinetrace::publishing {
namespace {

using test::MessageReader;
using test::PublisherFixture;
using test::SampleResult;

template <typename T>
class NativeReader : public MessageReader<T> {
 public:
  NativeReader(const PublisherFixture& fixture, const dds_topic_descriptor_t& type, const char* topic,
               bool gets_kept = false)
      : MessageReader<T>(fixture.domain(), type, topic, DDS_DATA_REPRESENTATION_XCDR2, gets_kept) {}
};

std::size_t total_objects(NativeReader<kinetrace_TrackedObjects>& reader, std::uint32_t& pieces) {
  std::size_t total = 0;
  pieces = 0;
  const kinetrace_TrackedObjects* message = reader.next();
  while (message != nullptr) {
    EXPECT_EQ(message->piece, pieces);
    ++pieces;
    total += message->objects._length;
    message = pieces == message->pieces ? nullptr : reader.next();
  }
  return total;
}

TEST(NativeMessages, CameraPoseSaysWhereAndHowFast) {
  PublisherFixture fixture({.device = "front"});
  NativeReader<kinetrace_CameraPose> reader(fixture, kinetrace_CameraPose_desc, topics::kCameraPose);
  fixture.publish(SampleResult({}, 7));
  const kinetrace_CameraPose* first = reader.next();
  ASSERT_NE(first, nullptr);
  EXPECT_STREQ(first->device, "front");
  EXPECT_EQ(first->frame, 7);
  EXPECT_EQ(first->timestamp_ns, SampleResult::timestamp_ns(7));
  EXPECT_EQ(first->handed_over_ns, PublisherFixture::kHandedOver_ns);
  EXPECT_EQ(first->status, kinetrace_STATUS_TRACKED);
  const Se3 expected = SampleResult::T_world_cam(7);
  EXPECT_DOUBLE_EQ(first->T_world_cam.position.z, expected.translation.z());
  EXPECT_NEAR(first->T_world_cam.orientation.w, expected.quaternion().w(), 1e-15);
  EXPECT_DOUBLE_EQ(first->covariance[35], 1e-4);
  EXPECT_EQ(first->velocity_mps.z, 0.0) << "nothing to compare with yet";

  fixture.publish(SampleResult({}, 8));
  const kinetrace_CameraPose* second = reader.next();
  ASSERT_NE(second, nullptr);
  EXPECT_NEAR(std::hypot(second->velocity_mps.x, second->velocity_mps.z), SampleResult::kSpeed_mps, 1e-6);
  EXPECT_NEAR(second->angular_velocity_radps.y, SampleResult::kTurn_radps, 1e-6);
}

TEST(NativeMessages, ObjectsCarryEverythingThatIsKnown) {
  PublisherFixture fixture({});
  NativeReader<kinetrace_TrackedObjects> reader(fixture, kinetrace_TrackedObjects_desc, topics::kObjects);
  fixture.publish(SampleResult({.objects = 2}, 3));
  const kinetrace_TrackedObjects* message = reader.next();
  ASSERT_NE(message, nullptr);
  EXPECT_EQ(message->frame, 3);
  EXPECT_EQ(message->pieces, 1U);
  EXPECT_EQ(message->total, 2U);
  ASSERT_EQ(message->objects._length, 2U);
  const kinetrace_TrackedObject& object = message->objects._buffer[0];
  const ObjectResult expected = SampleResult::object(1, 3);
  EXPECT_EQ(object.id, 1U);
  EXPECT_EQ(object.class_id, expected.class_id);
  EXPECT_TRUE(object.moving);
  EXPECT_FALSE(message->objects._buffer[1].moving);
  EXPECT_DOUBLE_EQ(object.T_world_obj.position.x, expected.T_world_obj.translation.x());
  EXPECT_FLOAT_EQ(object.covariance[0], 0.01F);
  EXPECT_FLOAT_EQ(object.covariance[4], 0.001F) << "row 0, column 4";
  EXPECT_FLOAT_EQ(object.covariance[20], 0.01F);
  EXPECT_FLOAT_EQ(object.velocity_mps[2], 2.0F);
  EXPECT_FLOAT_EQ(object.box_size_m[1], 1.5F);
  EXPECT_FLOAT_EQ(object.box_yaw_rad, -1.3F);
  EXPECT_FLOAT_EQ(object.box_down[1], 1.F);
  EXPECT_FLOAT_EQ(object.box_center_sigma_m[0], 0.5F);
  EXPECT_FLOAT_EQ(object.box_size_sigma_m[2], 0.25F);
  EXPECT_FLOAT_EQ(object.box_yaw_sigma_rad, 0.05F);
  EXPECT_TRUE(object.heading_known);
  EXPECT_EQ(object.box_px[3], 70);
  EXPECT_EQ(object.points, 40U);
  EXPECT_EQ(object.inliers, 30U);
}

TEST(NativeMessages, NoObjectsIsAMessageToo) {
  PublisherFixture fixture({});
  NativeReader<kinetrace_TrackedObjects> reader(fixture, kinetrace_TrackedObjects_desc, topics::kObjects);
  fixture.publish(SampleResult({.objects = 0}));
  const kinetrace_TrackedObjects* message = reader.next();
  ASSERT_NE(message, nullptr);
  EXPECT_EQ(message->pieces, 1U);
  EXPECT_EQ(message->objects._length, 0U);
}

TEST(NativeMessages, AsManyObjectsAsThereCanBeArriveInSmallPieces) {
  PublishConfig config;
  config.piece_bytes = PublishConfig::kMinPieceBytes;
  PublisherFixture fixture(config);
  NativeReader<kinetrace_TrackedObjects> reader(fixture, kinetrace_TrackedObjects_desc, topics::kObjects);
  fixture.publish(SampleResult({.objects = kMaxObjects}));
  std::uint32_t pieces = 0;
  EXPECT_EQ(total_objects(reader, pieces), 64U);
  EXPECT_GT(pieces, 3U);
}

TEST(NativeMessages, ObjectsBeyondTheCapacityAreLeftOut) {
  PublishConfig config;
  config.max_objects = 5;
  PublisherFixture fixture(config);
  NativeReader<kinetrace_TrackedObjects> reader(fixture, kinetrace_TrackedObjects_desc, topics::kObjects);
  fixture.publish(SampleResult({.objects = 6}));
  std::uint32_t pieces = 0;
  EXPECT_EQ(total_objects(reader, pieces), 5U);
}

TEST(NativeMessages, PointsComeInPiecesAndInTheWorldFrame) {
  PublisherFixture fixture({});
  NativeReader<kinetrace_PointPiece> reader(fixture, kinetrace_PointPiece_desc, topics::kPoints);
  fixture.publish(SampleResult({.objects = 1, .background_points = 1500, .points_per_object = 500}));
  std::vector<std::uint32_t> ids;
  std::vector<float> last;
  std::uint32_t pieces = 1;
  for (std::uint32_t i = 0; i < pieces; ++i) {
    const kinetrace_PointPiece* message = reader.next();
    ASSERT_NE(message, nullptr) << "piece " << i << " of " << pieces;
    EXPECT_EQ(message->piece, i);
    EXPECT_EQ(message->total, 2000U);
    EXPECT_EQ(message->available, 2000U);
    ASSERT_EQ(message->position_m._length, 3 * message->track_id._length);
    ASSERT_EQ(message->intensity._length, message->track_id._length);
    pieces = message->pieces;
    ids.insert(ids.end(), message->track_id._buffer, message->track_id._buffer + message->track_id._length);
    last.assign(message->position_m._buffer + message->position_m._length - 3,
                message->position_m._buffer + message->position_m._length);
  }
  EXPECT_EQ(pieces, 3U) << "2000 points of 17 bytes in pieces of 16 kB";
  EXPECT_EQ(ids.size(), 2000U);
  EXPECT_EQ(std::count(ids.begin(), ids.end(), 0U), 1500);
  const Eigen::Vector3d expected = SampleResult::object(1, 0).T_world_obj * SampleResult::point(1, 499).cast<double>();
  EXPECT_NEAR(last[0], expected.x(), 1e-4);
  EXPECT_NEAR(last[2], expected.z(), 1e-4);
}

TEST(NativeMessages, TrajectoriesArriveWholeAndSayWhenTheyAreFinished) {
  PublisherFixture fixture({});
  NativeReader<kinetrace_TrajectoryPiece> reader(fixture, kinetrace_TrajectoryPiece_desc, topics::kTrajectories);
  constexpr int kFrames = 100;
  for (int frame = 0; frame < kFrames; ++frame) {
    fixture.publish(SampleResult({.objects = 1}, frame));
  }
  fixture.mailbox().end_trajectories();
  fixture.serve();
  const kinetrace_TrajectoryPiece* full = reader.next();
  ASSERT_NE(full, nullptr);
  EXPECT_EQ(full->id, 1U);
  EXPECT_EQ(full->first_pose, 0U);
  EXPECT_FALSE(full->finished);
  ASSERT_EQ(full->poses._length, 64U);
  EXPECT_EQ(full->poses._buffer[63].frame, 63);
  EXPECT_DOUBLE_EQ(full->poses._buffer[63].position.z, SampleResult::object(1, 63).T_world_obj.translation.z());
  const kinetrace_TrajectoryPiece* last = reader.next();
  ASSERT_NE(last, nullptr);
  EXPECT_EQ(last->first_pose, 64U);
  EXPECT_TRUE(last->finished);
  EXPECT_EQ(last->poses._length, 36U);
  EXPECT_FLOAT_EQ(last->poses._buffer[35].velocity_mps[2], 2.0F);
  EXPECT_EQ(last->poses._buffer[35].status, kinetrace_STATUS_TRACKED);
}

TEST(NativeMessages, HealthNamesReasonsAndCounts) {
  PublisherFixture fixture({});
  NativeReader<kinetrace_Health> reader(fixture, kinetrace_Health_desc, topics::kHealth);
  PublishedHealth health;
  health.frame_index = 12;
  health.state = HealthState::kDegraded;
  health.camera = "streaming";
  health.entries[static_cast<std::size_t>(HealthReason::kFramesLost)] = {HealthReason::kFramesLost, 3, 5, 9};
  health.counters.tracks_born = 17;
  fixture.mailbox().offer_health(health);
  fixture.serve();
  const kinetrace_Health* message = reader.next();
  ASSERT_NE(message, nullptr);
  EXPECT_EQ(message->state, kinetrace_HEALTH_DEGRADED);
  EXPECT_STREQ(message->camera, "streaming");
  ASSERT_EQ(message->reasons._length, 1U);
  EXPECT_STREQ(message->reasons._buffer[0].name, "frames_lost");
  EXPECT_EQ(message->reasons._buffer[0].count, 3U);
  EXPECT_EQ(message->reasons._buffer[0].last_frame, 9);
  const auto* counters = message->counters._buffer;
  const auto born = std::find_if(counters, counters + message->counters._length,
                                 [](const kinetrace_Counter& c) { return std::string(c.name) == "tracks_born"; });
  ASSERT_NE(born, counters + message->counters._length);
  EXPECT_EQ(born->value, 17U);
}

TEST(NativeMessages, HealthTellsWhatIsKnownOfTheCalibration) {
  PublisherFixture fixture({});
  NativeReader<kinetrace_Health> reader(fixture, kinetrace_Health_desc, topics::kHealth);
  PublishedHealth health;
  health.rig.verdict = RigVerdict::kCorrected;
  health.rig.correction.turn_rad.y() = 1.0 / 721.5;
  health.rig.correction.focal = 0.01;
  health.rig.disparity_sigma_rad = 0.05 / 721.5;
  health.rig.sigma_rad[RigCorrection::kFocal] = 0.003;
  health.rig.applied.turn_rad.y() = 0.9 / 721.5;
  health.rig.windows = 12;
  fixture.mailbox().offer_health(health);
  fixture.serve();
  const kinetrace_Health* message = reader.next();
  ASSERT_NE(message, nullptr);
  const kinetrace_CalibrationEstimate& published = message->calibration;
  EXPECT_EQ(published.verdict, kinetrace_CALIBRATION_CORRECTED);
  EXPECT_DOUBLE_EQ(published.estimate[6], 0.01);
  EXPECT_DOUBLE_EQ(published.sigma[6], 0.003);
  EXPECT_DOUBLE_EQ(published.applied[1], 0.9 / 721.5);
  EXPECT_NEAR(published.disparity_error_px, 1.0, 1e-9);
  EXPECT_NEAR(published.disparity_sigma_px, 0.05, 1e-9);
  EXPECT_DOUBLE_EQ(published.depth_m[3], 50.0);
  EXPECT_LT(published.depth_error_m[3], -5.0);
  EXPECT_EQ(published.windows, 12U);
}

TEST(NativeMessages, WhoComesLaterStillGetsTheCalibration) {
  PublisherFixture fixture({});
  NativeReader<kinetrace_Calibration> reader(fixture, kinetrace_Calibration_desc, topics::kCalibration, true);
  const kinetrace_Calibration* message = reader.next();
  ASSERT_NE(message, nullptr);
  EXPECT_EQ(message->width_px, 1242U);
  EXPECT_DOUBLE_EQ(message->fx_px, 721.5);
  EXPECT_DOUBLE_EQ(message->baseline_m, 0.54);
}

}  // namespace
}  // namespace kinetrace::publishing

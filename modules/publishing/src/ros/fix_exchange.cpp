#include "kinetrace/publishing/fix_exchange.hpp"

#include <array>
#include <cstdio>
#include <span>
#include <utility>

#include "ros/ros_axes.hpp"
#include "ros/ros_topic_table.hpp"
#include "ros/ros_values.hpp"
#include "transport/outbox.hpp"
#include "transport/sequences.hpp"
#include "transport/topic_reader.hpp"

namespace kinetrace::publishing {
namespace {

using Fix = sensor_msgs_msg_dds__NavSatFix_;
using RowMajor3d = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

constexpr std::uint8_t kCovarianceUnknown = 0;  // sensor_msgs/NavSatFix.
constexpr std::uint8_t kCovarianceKnown = 3;
constexpr std::uint8_t kWarning = 1;  // diagnostic_msgs/DiagnosticStatus.

NavSatFix fix_of(const Fix& message) {
  constexpr std::int64_t kSecond_ns = 1'000'000'000;
  return {.stamp_ns = message.header.stamp.sec * kSecond_ns + message.header.stamp.nanosec,
          .frame = message.header.frame_id == nullptr ? "" : message.header.frame_id,
          .has_fix = message.status.status >= 0,
          .latitude_deg = message.latitude,
          .longitude_deg = message.longitude,
          .height_m = message.altitude,
          .covariance_known = message.position_covariance_type != kCovarianceUnknown,
          .covariance_m2 = Eigen::Map<const RowMajor3d>(message.position_covariance)};
}

Fix message_of(const NavSatFix& fix, const char* frame) noexcept {
  Fix message{};
  message.header = {ros_time(fix.stamp_ns), ros_text(frame)};
  message.status.status = static_cast<std::int8_t>(fix.has_fix ? 0 : -1);
  message.latitude = fix.latitude_deg;
  message.longitude = fix.longitude_deg;
  message.altitude = fix.height_m;
  Eigen::Map<RowMajor3d>(static_cast<double*>(message.position_covariance)) = fix.covariance_m2;
  message.position_covariance_type = fix.covariance_known ? kCovarianceKnown : kCovarianceUnknown;
  return message;
}

}  // namespace

struct FixReader::Impl {
  InLink<TopicReader> reader;
  std::string topic;
};

FixReader::FixReader(Link& link, const std::string& topic) : impl_(new Impl{InLink<TopicReader>(link), "rt" + topic}) {}
FixReader::~FixReader() = default;

Status FixReader::take(const std::function<void(const NavSatFix&)>& visit) {
  const Result<TopicReader*> reader = impl_->reader.get([this](const LinkMembership& membership) {
    constexpr TopicQos kQos{.encoding = Encoding::kRos, .depth = 64, .best_effort = true};
    return TopicReader::create(impl_->reader.link(), membership, sensor_msgs_msg_dds__NavSatFix__desc, impl_->topic,
                               kQos);
  });
  if (!reader) {
    return Unexpected(reader.error());
  }
  if (*reader != nullptr) {
    (*reader)->take<Fix>([&](const Fix& message) { visit(fix_of(message)); });
  }
  return {};
}

std::uint32_t FixReader::senders() const noexcept {
  const TopicReader* reader = impl_->reader.peek();
  return reader == nullptr ? 0 : reader->writers();
}

namespace {

struct MapWriters {
  Writer transforms;
  Writer camera;
  Writer objects;
  Writer diagnostics;
};

Result<MapWriters> make_map_writers(const LinkMembership& membership, const std::string& prefix) {
  MapWriters made;
  const auto spec = [&](Writer& writer, RosTopic topic) {
    const RosTopicKind& kind = kind_of(topic);
    return TopicSpec{writer, *kind.type, kind.dds_name(prefix), kind.qos, Priority::kEssential};
  };
  const std::array<TopicSpec, 4> specs{spec(made.transforms, RosTopic::kTransforms), spec(made.camera, RosTopic::kFix),
                                       spec(made.objects, RosTopic::kObjectFixes),
                                       spec(made.diagnostics, RosTopic::kDiagnostics)};
  if (const Status writers = make_writers(membership.participant, specs); !writers) {
    return Unexpected(writers.error());
  }
  return made;
}

}  // namespace

struct MapSender::Impl {
  InLink<MapWriters> writers;
  PublishConfig config;
  Outbox outbox;

  /// Null without readers.
  template <typename Message>
  void write(Writer MapWriters::*writer, const Message& message) noexcept {
    if (const MapWriters* all = writers.peek(); all != nullptr && Outbox::is_wanted(all->*writer)) {
      constexpr std::size_t kTextBytes = 128;
      outbox.write(all->*writer, &message, sizeof(message) + kTextBytes);
    }
  }
};

MapSender::MapSender(Link& link, const PublishConfig& config)
    : impl_(new Impl{InLink<MapWriters>(link), config, Outbox(config.bytes_per_second, config.piece_bytes)}) {}
MapSender::~MapSender() = default;

Status MapSender::supervise(std::int64_t now_ns) {
  impl_->outbox.refill(now_ns);
  const Result<MapWriters*> made = impl_->writers.get(
      [this](const LinkMembership& membership) { return make_map_writers(membership, impl_->config.ros2.prefix); });
  return made ? Status{} : Unexpected(made.error());
}

void MapSender::send_transform(std::int64_t stamp_ns, const Se3& T_map_world) noexcept {
  const RosConfig& ros = impl_->config.ros2;
  const Se3 T_map_odom{T_map_world.rotation * ros_axes().transpose(), T_map_world.translation};
  geometry_msgs_msg_dds__TransformStamped_ transform{
      {ros_time(stamp_ns), ros_text(ros.map_frame)}, ros_text(ros.odom_frame), ros_transform(T_map_odom)};
  tf2_msgs_msg_dds__TFMessage_ message{};
  set_items(message.transforms, {&transform, 1});
  impl_->write(&MapWriters::transforms, message);
}

void MapSender::send_camera(const NavSatFix& fix) noexcept {
  impl_->write(&MapWriters::camera, message_of(fix, impl_->config.ros2.base_frame.c_str()));
}

void MapSender::send_object(std::uint32_t track_id, const NavSatFix& fix) noexcept {
  std::array<char, 24> frame{};
  std::snprintf(frame.data(), frame.size(), "object_%u", track_id);
  impl_->write(&MapWriters::objects, message_of(fix, frame.data()));
}

void MapSender::send(const MapDiagnostics& diagnostics, std::int64_t stamp_ns) {
  const std::string text(diagnostics.message);
  const std::array<std::string, 3> numbers{std::to_string(diagnostics.fixes), std::to_string(diagnostics.inliers),
                                           std::to_string(diagnostics.position_sigma_m)};
  std::array<diagnostic_msgs_msg_dds__KeyValue_, 3> values{{{ros_text("fixes"), ros_text(numbers[0])},
                                                            {ros_text("inliers"), ros_text(numbers[1])},
                                                            {ros_text("position_sigma_m"), ros_text(numbers[2])}}};
  diagnostic_msgs_msg_dds__DiagnosticStatus_ status{};
  status.level = diagnostics.is_aligned ? 0 : kWarning;
  status.name = ros_text("kinetrace map");
  status.message = ros_text(text);
  status.hardware_id = ros_text(impl_->config.device);
  set_items(status.values, values);
  diagnostic_msgs_msg_dds__DiagnosticArray_ message{};
  message.header = {ros_time(stamp_ns), ros_text("")};
  set_items(message.status, {&status, 1});
  impl_->write(&MapWriters::diagnostics, message);
}

}  // namespace kinetrace::publishing

#include "kinetrace/publishing/result_reader.hpp"

#include <algorithm>
#include <array>
#include <memory>
#include <utility>

#include "kinetrace.h"
#include "kinetrace/publishing/topics.hpp"
#include "native_values.hpp"
#include "topic_reader.hpp"

namespace kinetrace::publishing {
namespace {

struct Readers {
  TopicReader camera;
  TopicReader objects;
  TopicReader health;
  TopicReader calibration;
};

Result<Readers> make_readers(const Link& link, const LinkMembership& membership) {
  // Deep enough for what comes while a terminal is slow.
  const TopicQos some{.depth = 64};
  const TopicQos kept{.depth = 1, .keeps_last = true};
  struct Spec {
    TopicReader Readers::*reader;
    const dds_topic_descriptor_t& type;
    const char* topic;
    TopicQos qos;
  };
  const std::array<Spec, 4> specs{{{&Readers::camera, kinetrace_CameraPose_desc, topics::kCameraPose, some},
                                   {&Readers::objects, kinetrace_TrackedObjects_desc, topics::kObjects, some},
                                   {&Readers::health, kinetrace_Health_desc, topics::kHealth, kept},
                                   {&Readers::calibration, kinetrace_Calibration_desc, topics::kCalibration, kept}}};
  Readers made;
  for (const Spec& spec : specs) {
    Result<TopicReader> reader = TopicReader::create(link, membership, spec.type, spec.topic, spec.qos);
    if (!reader) {
      return Unexpected(reader.error());
    }
    made.*spec.reader = std::move(*reader);
  }
  return made;
}

ObjectResult object_of(const kinetrace_TrackedObject& message) noexcept {
  ObjectResult object;
  object.track_id = message.id;
  object.class_id = message.class_id;
  object.status = body_status(message.status);
  object.moving = message.moving;
  object.T_world_obj = from_wire(message.T_world_obj);
  object.covariance = symmetric_from_upper_triangle(message.covariance);
  object.velocity_mps = Eigen::Map<const Eigen::Vector3f>(message.velocity_mps).cast<double>();
  object.heading_rad = message.heading_rad;
  object.box.center_m = from_wire(message.box_center_m);
  object.box.size_m = Eigen::Map<const Eigen::Vector3f>(message.box_size_m).cast<double>();
  object.box.yaw_rad = message.box_yaw_rad;
  object.box_px = {message.box_px[0], message.box_px[1], message.box_px[2], message.box_px[3]};
  object.point_count = static_cast<int>(message.points);
  object.inliers = static_cast<int>(message.inliers);
  return object;
}

HeardCamera camera_of(const kinetrace_CameraPose& message) noexcept {
  HeardCamera heard;
  heard.device = message.device;
  heard.frame_index = message.frame;
  heard.timestamp_ns = message.timestamp_ns;
  heard.handed_over_ns = message.handed_over_ns;
  heard.camera.status = body_status(message.status);
  heard.camera.T_world_cam = from_wire(message.T_world_cam);
  heard.camera.covariance = Eigen::Map<const Matrix6d>(message.covariance);  // Symmetric.
  heard.velocity_mps = from_wire(message.velocity_mps);
  return heard;
}

void tell(const kinetrace_TrackedObjects& message, ResultListener& listener) {
  std::array<ObjectResult, kMaxObjects> objects;
  const std::size_t count = std::min<std::size_t>(message.objects._length, objects.size());
  std::transform(message.objects._buffer, message.objects._buffer + count, objects.begin(), object_of);
  listener.hear(HeardObjects{message.device, message.frame, message.timestamp_ns, message.piece, message.pieces,
                             std::span(objects).first(count)});
}

void tell(const kinetrace_Health& message, ResultListener& listener) {
  std::array<HeardReason, 32> reasons;  // Bounds in the IDL.
  std::array<HeardCounter, 64> counters;
  const std::size_t reason_count = std::min<std::size_t>(message.reasons._length, reasons.size());
  const std::size_t counter_count = std::min<std::size_t>(message.counters._length, counters.size());
  std::transform(message.reasons._buffer, message.reasons._buffer + reason_count, reasons.begin(),
                 [](const kinetrace_HealthReason& r) {
                   return HeardReason{r.name, r.count, r.first_frame, r.last_frame};
                 });
  std::transform(message.counters._buffer, message.counters._buffer + counter_count, counters.begin(),
                 [](const kinetrace_Counter& c) {
                   return HeardCounter{c.name, c.value};
                 });
  listener.hear(HeardHealth{message.device, message.frame, health_state(message.state), message.camera,
                            std::span(reasons).first(reason_count), std::span(counters).first(counter_count)});
}

HeardCalibration calibration_of(const kinetrace_Calibration& message) noexcept {
  return {message.device,
          {.fx_px = message.fx_px,
           .fy_px = message.fy_px,
           .cx_px = message.cx_px,
           .cy_px = message.cy_px,
           .baseline_m = message.baseline_m,
           .width_px = static_cast<int>(message.width_px),
           .height_px = static_cast<int>(message.height_px)}};
}

}  // namespace

struct ResultReader::Impl {
  InLink<Readers> readers;
};

ResultReader::ResultReader(Link& link) : impl_(new Impl{InLink<Readers>(link)}) {}
ResultReader::~ResultReader() = default;

Status ResultReader::take(ResultListener& listener) {
  const Result<Readers*> readers = impl_->readers.get(
      [&](const LinkMembership& membership) { return make_readers(impl_->readers.link(), membership); });
  if (!readers) {
    return Unexpected(readers.error());
  }
  if (*readers == nullptr) {
    return {};
  }
  Readers& all = **readers;
  all.calibration.take<kinetrace_Calibration>([&](const auto& message) { listener.hear(calibration_of(message)); });
  all.health.take<kinetrace_Health>([&](const auto& message) { tell(message, listener); });
  all.camera.take<kinetrace_CameraPose>([&](const auto& message) { listener.hear(camera_of(message)); });
  all.objects.take<kinetrace_TrackedObjects>([&](const auto& message) { tell(message, listener); });
  return {};
}

}  // namespace kinetrace::publishing

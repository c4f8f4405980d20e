#include "native/native_samples.hpp"

#include <algorithm>
#include <array>

#include "native/native_values.hpp"

namespace kinetrace::publishing {
namespace {

Eigen::Vector3d vector_of(const float (&values)[3]) noexcept {
  return Eigen::Map<const Eigen::Vector3f>(values).cast<double>();
}

ObjectResult object_of(const kinetrace_TrackedObject& message) noexcept {
  ObjectResult object;
  object.track_id = message.id;
  object.class_id = message.class_id;
  object.status = body_status(message.status);
  object.moving = message.moving;
  object.T_world_obj = from_wire(message.T_world_obj);
  object.covariance = symmetric_from_upper_triangle(message.covariance);
  object.velocity_mps = vector_of(message.velocity_mps);
  object.heading_rad = message.heading_rad;
  object.box.center_m = from_wire(message.box_center_m);
  object.box.size_m = vector_of(message.box_size_m);
  object.box.yaw_rad = message.box_yaw_rad;
  object.box.down = vector_of(message.box_down);
  object.box_sigma = {vector_of(message.box_center_sigma_m), vector_of(message.box_size_sigma_m),
                      double{message.box_yaw_sigma_rad}, message.heading_known};
  object.box_px = {message.box_px[0], message.box_px[1], message.box_px[2], message.box_px[3]};
  object.point_count = static_cast<int>(message.points);
  object.inliers = static_cast<int>(message.inliers);
  return object;
}

RigEstimate rig_of(const kinetrace_CalibrationEstimate& message) {
  using Vector = Eigen::Map<const RigCorrection::Vector>;
  RigEstimate rig;
  rig.verdict = rig_verdict(message.verdict);
  rig.correction = RigCorrection::from(Vector(message.estimate));
  rig.sigma_rad = Vector(message.sigma);
  rig.applied = RigCorrection::from(Vector(message.applied));
  rig.windows = message.windows;
  rig.knocks = message.knocks;
  return rig;
}

}  // namespace

void tell(const kinetrace_CameraPose& message, ResultListener& listener) {
  ReceivedCamera received;
  received.device = message.device;
  received.frame_index = message.frame;
  received.timestamp_ns = message.timestamp_ns;
  received.handed_over_ns = message.handed_over_ns;
  received.camera.status = body_status(message.status);
  received.camera.T_world_cam = from_wire(message.T_world_cam);
  received.camera.covariance = Eigen::Map<const Matrix6d>(message.covariance);  // Symmetric.
  received.velocity_mps = from_wire(message.velocity_mps);
  listener.receive(received);
}

void tell(const kinetrace_TrackedObjects& message, ResultListener& listener) {
  std::array<ObjectResult, kMaxObjects> objects;
  const std::size_t count = std::min<std::size_t>(message.objects._length, objects.size());
  std::transform(message.objects._buffer, message.objects._buffer + count, objects.begin(), object_of);
  listener.receive(ReceivedObjects{message.device, message.frame, message.timestamp_ns, message.piece, message.pieces,
                                   std::span(objects).first(count)});
}

void tell(const kinetrace_Health& message, ResultListener& listener) {
  std::array<ReceivedReason, 32> reasons;  // Bounds in the IDL.
  std::array<ReceivedCounter, 64> counters;
  const std::size_t reason_count = std::min<std::size_t>(message.reasons._length, reasons.size());
  const std::size_t counter_count = std::min<std::size_t>(message.counters._length, counters.size());
  std::transform(message.reasons._buffer, message.reasons._buffer + reason_count, reasons.begin(),
                 [](const kinetrace_HealthReason& r) {
                   return ReceivedReason{r.name, r.count, r.first_frame, r.last_frame};
                 });
  std::transform(message.counters._buffer, message.counters._buffer + counter_count, counters.begin(),
                 [](const kinetrace_Counter& c) {
                   return ReceivedCounter{c.name, c.value};
                 });
  listener.receive(ReceivedHealth{message.device, message.frame, health_state(message.state), message.camera,
                                  std::span(reasons).first(reason_count), std::span(counters).first(counter_count),
                                  rig_of(message.calibration)});
}

void tell(const kinetrace_Calibration& message, ResultListener& listener) {
  listener.receive(ReceivedCalibration{message.device,
                                       {.fx_px = message.fx_px,
                                        .fy_px = message.fy_px,
                                        .cx_px = message.cx_px,
                                        .cy_px = message.cy_px,
                                        .baseline_m = message.baseline_m,
                                        .width_px = static_cast<int>(message.width_px),
                                        .height_px = static_cast<int>(message.height_px)}});
}

void tell(const kinetrace_InstanceMasks& message, std::uint64_t sender,
          const std::function<void(const MaskMessage&)>& visit) {
  std::array<RunLengthMask, kMaxMasksInMessage> masks;
  const std::size_t count = std::min<std::size_t>(message.masks._length, masks.size());
  std::transform(message.masks._buffer, message.masks._buffer + count, masks.begin(),
                 [](const kinetrace_InstanceMask& mask) {
                   return RunLengthMask{mask.class_id,
                                        mask.score,
                                        {mask.x0_px, mask.y0_px, mask.x1_px, mask.y1_px},
                                        {mask.runs._buffer, mask.runs._length}};
                 });
  visit({sender, message.frame, message.timestamp_ns, message.view == 0 ? View::kLeft : View::kRight, message.width_px,
         message.height_px, message.piece, message.pieces, std::span(masks).first(count)});
}

}  // namespace kinetrace::publishing

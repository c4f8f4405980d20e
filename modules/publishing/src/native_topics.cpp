#include "native_topics.hpp"

#include <algorithm>

#include "kinetrace/publishing/topics.hpp"

namespace kinetrace::publishing {
namespace {

template <std::size_t N>
void copy_text(std::string_view text, char (&out)[N]) noexcept {
  const std::size_t size = std::min(text.size(), N - 1);
  std::copy_n(text.data(), size, out);
  out[size] = '\0';
}

kinetrace_Vector3 to_wire(const Eigen::Vector3d& v) noexcept {
  return {v.x(), v.y(), v.z()};
}

kinetrace_Pose to_wire(const Se3& pose) noexcept {
  const Eigen::Quaterniond q = pose.quaternion();
  return {to_wire(pose.translation), {q.x(), q.y(), q.z(), q.w()}};
}

}  // namespace

NativeBuffers::NativeBuffers(const PublishConfig& config, Arena& arena)
    : objects(arena.take<kinetrace_TrackedObject>(static_cast<std::size_t>(config.max_objects))) {}

Result<NativeTopics> NativeTopics::create(const PublishConfig& config, dds_entity_t participant) {
  NativeTopics made;
  made.device_ = config.device;
  struct Topic {
    Writer& writer;
    const dds_topic_descriptor_t& type;
    const char* name;
    TopicQos qos;
    Priority priority;
  };
  for (const Topic& topic :
       {Topic{made.camera_pose_, kinetrace_CameraPose_desc, topics::kCameraPose, {}, Priority::kEssential},
        Topic{made.calibration_,
              kinetrace_Calibration_desc,
              topics::kCalibration,
              {.keeps_last = true},
              Priority::kEssential}}) {
    Result<Writer> writer = Writer::create(participant, topic.type, topic.name, topic.qos, topic.priority);
    if (!writer) {
      return tl::unexpected(writer.error());
    }
    topic.writer = std::move(*writer);
  }
  return made;
}

void NativeTopics::publish(const StereoGeometry& geometry, Outbox& outbox) const {
  kinetrace_Calibration message{};
  copy_text(device_, message.device);
  message.width_px = static_cast<std::uint32_t>(geometry.width_px);
  message.height_px = static_cast<std::uint32_t>(geometry.height_px);
  message.fx_px = geometry.fx_px;
  message.fy_px = geometry.fy_px;
  message.cx_px = geometry.cx_px;
  message.cy_px = geometry.cy_px;
  message.baseline_m = geometry.baseline_m;
  outbox.write(calibration_, &message, sizeof(message));
}

void NativeTopics::publish(const PublishedFrame& frame, const CameraMotion& motion, const NativeBuffers& /*buffers*/,
                           Outbox& outbox) const {
  publish_camera(frame, motion, outbox);
}

void NativeTopics::publish_camera(const PublishedFrame& frame, const CameraMotion& motion, Outbox& outbox) const {
  if (!Outbox::is_wanted(camera_pose_)) {
    return;
  }
  kinetrace_CameraPose message{};
  copy_text(device_, message.device);
  message.frame = frame.frame_index;
  message.timestamp_ns = frame.timestamp_ns;
  message.handed_over_ns = frame.handed_over_ns;
  message.status = static_cast<std::uint8_t>(frame.camera.status);
  message.T_world_cam = to_wire(frame.camera.T_world_cam);
  Eigen::Map<Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(message.covariance) = frame.camera.covariance;
  message.velocity_mps = to_wire(motion.velocity_mps);
  message.angular_velocity_radps = to_wire(motion.angular_velocity_radps);
  outbox.write(camera_pose_, &message, sizeof(message));
}

}  // namespace kinetrace::publishing

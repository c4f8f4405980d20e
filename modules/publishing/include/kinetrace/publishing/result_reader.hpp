// Receives the native topics of another Kinetrace.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include <Eigen/Core>

#include "kinetrace/core/export.hpp"
#include "kinetrace/core/frame_result.hpp"
#include "kinetrace/core/health.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/core/stereo_geometry.hpp"
#include "kinetrace/publishing/link.hpp"

namespace kinetrace::publishing {

// Frames and units as in FrameResult. Views are valid during the call that receives them. An unknown status is read as
// the worst one.

struct ReceivedCamera {
  std::string_view device;
  std::int64_t frame_index = 0;
  std::int64_t timestamp_ns = 0;
  std::int64_t handed_over_ns = 0;  ///< System clock (Unix) of the sender.
  CameraResult camera;
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();  ///< Camera's frame.
};

/// Objects of one frame, complete or a piece.
struct ReceivedObjects {
  std::string_view device;
  std::int64_t frame_index = 0;
  std::int64_t timestamp_ns = 0;
  std::uint32_t piece = 0;
  std::uint32_t pieces = 1;
  std::span<const ObjectResult> objects;  ///< Without label and T_obj_cam.
};

struct ReceivedReason {
  std::string_view name;
  std::uint64_t count = 0;
  std::int64_t first_frame = 0;
  std::int64_t last_frame = 0;
};
struct ReceivedCounter {
  std::string_view name;
  std::uint64_t value = 0;
};
struct ReceivedHealth {
  std::string_view device;
  std::int64_t frame_index = 0;
  HealthState state = HealthState::kLost;
  std::string_view camera;
  std::span<const ReceivedReason> reasons;
  std::span<const ReceivedCounter> counters;
  RigEstimate rig;  ///< Verdict, correction and sigmas, what is applied, windows and knocks.
};

struct ReceivedCalibration {
  std::string_view device;
  StereoGeometry geometry;
};

class KINETRACE_API ResultListener {
 public:
  ResultListener() = default;
  ResultListener(const ResultListener&) = delete;
  ResultListener& operator=(const ResultListener&) = delete;
  ResultListener(ResultListener&&) = delete;
  ResultListener& operator=(ResultListener&&) = delete;
  virtual ~ResultListener() = default;
  virtual void receive(const ReceivedCamera& camera) = 0;
  virtual void receive(const ReceivedObjects& objects) = 0;
  virtual void receive(const ReceivedHealth& health) = 0;
  virtual void receive(const ReceivedCalibration& calibration) = 0;
};

/// Reads poses, objects, health and calibration of all devices in the domain. Points and trajectories are not read, so
/// that the sender need not send them. Memory is bounded by the depth of the topics.
class KINETRACE_API ResultReader {
 public:
  /// `link` must outlive it.
  explicit ResultReader(Link& link);
  ResultReader(const ResultReader&) = delete;
  ResultReader& operator=(const ResultReader&) = delete;
  ~ResultReader();

  /// Passes on all messages since the last call; does not wait, see Link::wait. No messages without a network. Errors:
  /// kIo if the DDS library refuses a topic.
  [[nodiscard]] Status take(ResultListener& listener);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace kinetrace::publishing

// GNSS fixes over ROS 2: reads those of a receiver; publishes positions of camera and objects on the map.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include <Eigen/Core>

#include "kinetrace/core/export.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/core/se3.hpp"
#include "kinetrace/publishing/link.hpp"
#include "kinetrace/publishing/publish_config.hpp"

namespace kinetrace::publishing {

/// sensor_msgs/NavSatFix. Views are valid during the call that receives them.
struct NavSatFix {
  std::int64_t stamp_ns = 0;
  std::string_view frame;  ///< Of the antenna, the camera or an object.
  bool has_fix = false;    ///< From the receiver's status; without it the position is invalid.
  double latitude_deg = 0.0;
  double longitude_deg = 0.0;
  double height_m = 0.0;  ///< Above the ellipsoid. NaN: not known.
  bool covariance_known = false;
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();  ///< East, north, up.
};

/// Reads the fixes of receivers on one topic, reliable or not. Memory is bounded by the depth of the topic. Fixes are
/// untrusted: the caller must check positions.
class KINETRACE_API FixReader {
 public:
  /// `topic`: ROS name, "/fix". `link` must outlive it.
  FixReader(Link& link, const std::string& topic);
  FixReader(const FixReader&) = delete;
  FixReader& operator=(const FixReader&) = delete;
  ~FixReader();

  /// Passes on all fixes since the last call; does not wait, see Link::wait. Errors: kIo if the DDS library refuses the
  /// topic.
  [[nodiscard]] Status take(const std::function<void(const NavSatFix&)>& visit);
  /// Number of matched receivers.
  [[nodiscard]] std::uint32_t senders() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// State of the alignment, for /diagnostics.
struct MapDiagnostics {
  bool is_aligned = false;
  std::string_view message;
  std::int64_t fixes = 0;  ///< Number in the window.
  std::int64_t inliers = 0;
  double position_sigma_m = 0.0;  ///< Horizontal, of the newest position.
};

/// Publishes the results of an aligned run: `/tf` from map to odom, `fix`, `object_fixes`, and the state of the
/// alignment on /diagnostics. Messages without readers or beyond the budget are not sent.
class KINETRACE_API MapSender {
 public:
  /// `link` must outlive it.
  MapSender(Link& link, const PublishConfig& config);
  MapSender(const MapSender&) = delete;
  MapSender& operator=(const MapSender&) = delete;
  ~MapSender();

  /// Call periodically, before the other functions. `now_ns` is a steady clock. Nothing is sent without a network.
  /// Errors: kIo if the DDS library refuses a topic.
  [[nodiscard]] Status supervise(std::int64_t now_ns);

  /// T_map_world: the map's axes are east, north and up, the world's those of the first camera.
  void send_transform(std::int64_t stamp_ns, const Se3& T_map_world) noexcept;
  /// `fix.frame` is ignored: the camera's frame is sent.
  void send_camera(const NavSatFix& fix) noexcept;
  /// With the frame "object_ID".
  void send_object(std::uint32_t track_id, const NavSatFix& fix) noexcept;
  void send(const MapDiagnostics& diagnostics, std::int64_t stamp_ns);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace kinetrace::publishing

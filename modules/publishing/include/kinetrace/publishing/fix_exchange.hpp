// Places on the Earth in ROS 2: a receiver's fixes in, where the camera and objects are on the map out.
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

/// sensor_msgs/NavSatFix. Views live as long as the call that they are given to.
struct NavSatFix {
  std::int64_t stamp_ns = 0;
  std::string_view frame;  ///< Of the antenna, the camera or an object.
  bool has_fix = false;    ///< As the receiver says; only then the place counts.
  double latitude_deg = 0.0;
  double longitude_deg = 0.0;
  double height_m = 0.0;  ///< Above the ellipsoid. NaN: not known.
  bool covariance_known = false;
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();  ///< East, north, up.
};

/// Reads the fixes of receivers on one topic, reliable or not. Memory is bounded by the depth of the topic. What comes
/// is not trusted: places are to be checked.
class KINETRACE_API FixReader {
 public:
  /// `topic` as ROS says it: "/fix". `link` outlives it.
  FixReader(Link& link, const std::string& topic);
  FixReader(const FixReader&) = delete;
  FixReader& operator=(const FixReader&) = delete;
  ~FixReader();

  /// Hands on everything that came since the last call; does not wait, see Link::wait. Errors: kIo where the DDS
  /// library refuses the topic.
  [[nodiscard]] Status take(const std::function<void(const NavSatFix&)>& visit);
  /// Receivers whose fixes are received.
  [[nodiscard]] std::uint32_t senders() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// How the alignment stands, for /diagnostics.
struct MapDiagnostics {
  bool is_aligned = false;
  std::string_view message;
  std::int64_t fixes = 0;  ///< In the window.
  std::int64_t inliers = 0;
  double position_sigma_m = 0.0;  ///< Horizontal, of the newest place.
};

/// Publishes what the alignment of a run makes of its results: `/tf` from map to odom, `fix`, `object_fixes`, and its
/// state on /diagnostics. What nobody reads, or the budget does not allow, is left out.
class KINETRACE_API MapSender {
 public:
  /// `link` outlives it.
  MapSender(Link& link, const PublishConfig& config);
  MapSender(const MapSender&) = delete;
  MapSender& operator=(const MapSender&) = delete;
  ~MapSender();

  /// Before the others, again and again. `now_ns` is a steady clock. Nothing is sent while there is no network.
  /// Errors: kIo where the DDS library refuses a topic.
  [[nodiscard]] Status supervise(std::int64_t now_ns);

  /// T_map_world: the map's axes are east, north and up, the world's those of the first camera.
  void send_transform(std::int64_t stamp_ns, const Se3& T_map_world) noexcept;
  /// `fix.frame` is not sent: it is that of the camera.
  void send_camera(const NavSatFix& fix) noexcept;
  /// With the frame "object_ID".
  void send_object(std::uint32_t track_id, const NavSatFix& fix) noexcept;
  void send(const MapDiagnostics& diagnostics, std::int64_t stamp_ns);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace kinetrace::publishing

// Configuration of publishing.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "kinetrace/core/export.hpp"
#include "kinetrace/core/image_view.hpp"
#include "kinetrace/core/result.hpp"

namespace kinetrace::publishing {

/// Discovery of participants on an interface other than the loopback. Data is sent to each reader by unicast unless
/// kAll.
enum class Multicast : std::uint8_t {
  kOff,        ///< Contacts `peers` only.
  kDiscovery,  ///< The default of ROS 2.
  kAll,        ///< Data, too: for several readers on a wired network; poor on most wireless ones.
};

[[nodiscard]] constexpr std::string_view to_string(Multicast multicast) noexcept {
  switch (multicast) {
    case Multicast::kOff: return "off";
    case Multicast::kDiscovery: return "discovery";
    case Multicast::kAll: return "all";
  }
  return "off";
}
/// For configuration files; returns false and changes nothing if `text` is none of the names.
[[nodiscard]] constexpr bool from_string(std::string_view text, Multicast& multicast) noexcept {
  for (const Multicast candidate : {Multicast::kOff, Multicast::kDiscovery, Multicast::kAll}) {
    if (text == to_string(candidate)) {
      multicast = candidate;
      return true;
    }
  }
  return false;
}

/// The clock of ROS 2 headers.
enum class RosStamps : std::uint8_t {
  kSystem,  ///< System clock when the pipeline handed the result over: the clock of other nodes in a live system.
  kSource,  ///< Time stamp of the camera or recording.
};

[[nodiscard]] constexpr std::string_view to_string(RosStamps stamps) noexcept {
  return stamps == RosStamps::kSource ? "source" : "system";
}
[[nodiscard]] constexpr bool from_string(std::string_view text, RosStamps& stamps) noexcept {
  if (text != "source" && text != "system") {
    return false;
  }
  stamps = text == "source" ? RosStamps::kSource : RosStamps::kSystem;
  return true;
}

/// Topics for ROS 2, beside or instead of the native ones. Frames follow REP 103 and 105; see the module's README.
struct RosConfig {
  bool enabled = true;
  std::string prefix = "kinetrace";  ///< Namespace of all topics but /tf, /tf_static and /diagnostics; may be empty.
  RosStamps stamps = RosStamps::kSystem;
  std::string map_frame = "map";           ///< East, north, up; parent of odom_frame while `kinetrace map` aligns.
  std::string odom_frame = "odom";         ///< World: x forward, y left, z up at the first frame; parent of base_frame.
  std::string base_frame = "camera_link";  ///< Left camera, x forward, y left, z up.
  std::string left_frame = "camera_left_optical_frame";    ///< At camera_link, x right, y down, z forward.
  std::string right_frame = "camera_right_optical_frame";  ///< One baseline to the right of it.
};

enum class SecurityMode : std::uint8_t {
  kOff,       ///< Nothing is loaded, nothing is encrypted.
  kRequired,  ///< DDS Security with a complete, valid set of files, or no start.
};

[[nodiscard]] constexpr std::string_view to_string(SecurityMode mode) noexcept {
  return mode == SecurityMode::kRequired ? "required" : "off";
}
[[nodiscard]] constexpr bool from_string(std::string_view text, SecurityMode& mode) noexcept {
  if (text != "off" && text != "required") {
    return false;
  }
  mode = text == "required" ? SecurityMode::kRequired : SecurityMode::kOff;
  return true;
}

/// Files of DDS Security, PEM and S/MIME. All must be set when required, none when off: files without effect would
/// suggest protection.
struct SecurityConfig {
  SecurityMode mode = SecurityMode::kOff;
  std::string identity_ca{};     ///< Certificate of the authority that signed the identities.
  std::string certificate{};     ///< This device's identity ...
  std::string private_key{};     ///< ... and its key.
  std::string permissions_ca{};  ///< Certificate that signed governance and permissions; empty: identity_ca.
  std::string governance{};      ///< Signed: protection of the domain.
  std::string permissions{};     ///< Signed: permissions of this device.
  std::string plugins{};         ///< Folder of Cyclone's security libraries; empty: where they are installed.
};

struct KINETRACE_API PublishConfig {
  static constexpr int kMaxDomain = 230;  ///< Port numbers are exhausted beyond.
  static constexpr int kMinPieceBytes = 4096;
  static constexpr int kMaxPieceBytes = 20'000;
  static constexpr int kMaxPoints = 20'000;
  static constexpr std::size_t kMaxDeviceLength = 31;

  int domain = 0;
  /// The only network interface. "lo" stays on this machine. A missing interface is waited for.
  std::string interface = "lo";
  std::string peers{};  ///< Addresses for unicast discovery, separated by commas; in addition to multicast.
  Multicast multicast = Multicast::kDiscovery;
  std::string device = "kinetrace";  ///< Name of the sender: the key of all native topics.
  bool native = true;
  RosConfig ros2{};
  int bytes_per_second = 4'000'000;  ///< User data, counted once per reader; priorities: see ByteBudget.
  int piece_bytes = 16'000;          ///< Larger messages are split.
  int max_points = 2000;             ///< Points of a frame, over all bodies; more are thinned evenly. 0: none.
  int trajectory_queue = 2048;       ///< Finalised poses that may wait for the publisher; more are dropped and counted.
  int log_lines_per_minute = 12;     ///< Of the DDS library; the rest is counted.
  /// Cyclone DDS configuration file for settings beyond these keys; empty: generated from the keys. It replaces
  /// interface, peers and multicast, and cannot be combined with security.
  std::string xml{};
  SecurityConfig security{};

  /// Objects in a frame. Set by the program from the pipeline's configuration; not a key.
  int max_objects = kMaxObjects;

  /// Checks ranges, names and contradictory combinations; opens no file. Errors: kInvalidConfig.
  [[nodiscard]] Status validate() const;
};

/// Calls `visit(key, field, description)` for every setting.
template <typename Config, typename Visitor>
void visit_fields(Config& config, Visitor&& visit) {
  visit("dds.domain", config.domain, "domain number, 0 to 230; ROS_DOMAIN_ID of ROS 2");
  visit("dds.interface", config.interface,
        "the one network interface that is used, waited for where it is missing; lo: this machine alone");
  visit("dds.peers", config.peers, "addresses asked for participants, separated by commas");
  visit("dds.multicast", config.multicast, "off, discovery or all; never on lo");
  visit("dds.device", config.device, "name of the sender, the key of native topics; at most 31 characters");
  visit("dds.native", config.native, "native topics, kinetrace/*");
  visit("dds.bytes_per_second", config.bytes_per_second,
        "maximum data rate over all readers, bytes per second; poses, objects and health go first, points last");
  visit("dds.piece_bytes", config.piece_bytes, "size above which messages come in pieces, bytes, 4096 to 20000");
  visit("dds.max_points", config.max_points, "maximum number of points of a frame, thinned evenly; 0: none");
  visit("dds.trajectory_queue", config.trajectory_queue,
        "maximum number of finalised poses that wait for the publisher");
  visit("dds.log_lines_per_minute", config.log_lines_per_minute,
        "maximum number of log lines of the DDS library per minute; the rest is counted");
  visit("dds.xml", config.xml, "own Cyclone DDS configuration instead of interface, peers and multicast");
  visit("dds.ros2.enabled", config.ros2.enabled, "topics for ROS 2");
  visit("dds.ros2.prefix", config.ros2.prefix, "namespace of all but /tf, /tf_static and /diagnostics");
  visit("dds.ros2.stamps", config.ros2.stamps, "clock of headers: system or source");
  visit("dds.ros2.map_frame", config.ros2.map_frame,
        "frame of the map: east, north, up; of a run that is aligned with a receiver");
  visit("dds.ros2.odom_frame", config.ros2.odom_frame,
        "frame of the world: x forward, y left, z up at the first frame");
  visit("dds.ros2.base_frame", config.ros2.base_frame, "frame of the left camera: x forward, y left, z up");
  visit("dds.ros2.left_frame", config.ros2.left_frame, "optical frame of the left camera: x right, y down, z forward");
  visit("dds.ros2.right_frame", config.ros2.right_frame, "optical frame of the right camera");
  visit("dds.security.mode", config.security.mode, "off or required");
  visit("dds.security.identity_ca", config.security.identity_ca, "certificate of the authority, PEM");
  visit("dds.security.certificate", config.security.certificate, "certificate of this device, PEM");
  visit("dds.security.private_key", config.security.private_key, "private key of this device, PEM");
  visit("dds.security.permissions_ca", config.security.permissions_ca,
        "certificate that signed governance and permissions; empty: identity_ca");
  visit("dds.security.governance", config.security.governance, "protection of the domain, signed");
  visit("dds.security.permissions", config.security.permissions, "permissions of this device, signed");
  visit("dds.security.plugins", config.security.plugins,
        "folder of Cyclone's security libraries; empty: where they are installed");
}

}  // namespace kinetrace::publishing

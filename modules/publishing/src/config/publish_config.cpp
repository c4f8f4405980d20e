#include "kinetrace/publishing/publish_config.hpp"

#include <algorithm>
#include <array>
#include <string>

#include "kinetrace/core/config_check.hpp"

namespace kinetrace::publishing {
namespace {

bool is_alphanumeric(char c) noexcept {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
}

/// Letters, digits and `others`, of a length in [1, longest].
Status check_name(std::string_view key, std::string_view name, std::string_view others, std::size_t longest) {
  const bool is_clean = std::all_of(
      name.begin(), name.end(), [&](char c) { return is_alphanumeric(c) || others.find(c) != std::string_view::npos; });
  if (is_clean && !name.empty() && name.size() <= longest) {
    return {};
  }
  return fail(ErrorCode::kInvalidConfig, std::string(key) + " must have 1 to " + std::to_string(longest) +
                                             " letters, digits or any of " + std::string(others) + ", got \"" +
                                             std::string(name) + "\"");
}

/// Names of ROS 2: parts joined by /, each beginning with a letter or _.
Status check_prefix(const std::string& prefix) {
  constexpr std::size_t kMax = 63;
  bool part_begins = true;
  bool is_clean = prefix.empty() || (prefix.back() != '/' && prefix.size() <= kMax);
  for (const char c : prefix) {
    const bool is_digit = c >= '0' && c <= '9';
    is_clean = is_clean && (part_begins ? c == '_' || (is_alphanumeric(c) && !is_digit)
                                        : c == '_' || c == '/' || is_alphanumeric(c));
    part_begins = c == '/';
  }
  if (is_clean) {
    return {};
  }
  return fail(
      ErrorCode::kInvalidConfig,
      "dds.ros2.prefix must be names of letters, digits and _ joined by /, such as car/front, got \"" + prefix + "\"");
}

Status check_peers(std::string_view peers) {
  constexpr std::size_t kMax = 63;
  while (!peers.empty()) {
    const std::size_t comma = std::min(peers.find(','), peers.size());
    if (Status valid = check_name("each of dds.peers", peers.substr(0, comma), ".:-", kMax); !valid) {
      return valid;
    }
    peers.remove_prefix(std::min(comma + 1, peers.size()));
  }
  return {};
}

Status check_frames(const RosConfig& ros) {
  constexpr std::size_t kMax = 63;
  const std::array<std::pair<std::string_view, std::string_view>, 5> frames{
      {{"dds.ros2.map_frame", ros.map_frame},
       {"dds.ros2.odom_frame", ros.odom_frame},
       {"dds.ros2.base_frame", ros.base_frame},
       {"dds.ros2.left_frame", ros.left_frame},
       {"dds.ros2.right_frame", ros.right_frame}}};
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (Status valid = check_name(frames[i].first, frames[i].second, "_-/.", kMax); !valid) {
      return valid;
    }
    for (std::size_t j = 0; j < i; ++j) {
      if (frames[i].second == frames[j].second) {
        return fail(ErrorCode::kInvalidConfig, std::string(frames[i].first) + " and " + std::string(frames[j].first) +
                                                   " are both \"" + std::string(frames[i].second) +
                                                   "\"; give each frame a name of its own");
      }
    }
  }
  return {};
}

Status check_security(const SecurityConfig& security) {
  const std::array<std::pair<std::string_view, const std::string*>, 5> needed{{{"identity_ca", &security.identity_ca},
                                                                               {"certificate", &security.certificate},
                                                                               {"private_key", &security.private_key},
                                                                               {"governance", &security.governance},
                                                                               {"permissions", &security.permissions}}};
  const bool is_required = security.mode == SecurityMode::kRequired;
  for (const auto& [name, file] : needed) {
    if (file->empty() == is_required) {
      const std::string key = "dds.security." + std::string(name);
      return fail(ErrorCode::kInvalidConfig,
                  is_required ? key + " is missing; dds.security.mode: required needs it"
                              : key + " is named, but dds.security.mode is off; set it to required, or name no file");
    }
  }
  return {};
}

Status check_xml(const PublishConfig& config) {
  if (!config.xml.empty() && config.security.mode == SecurityMode::kRequired) {
    return fail(ErrorCode::kInvalidConfig,
                "dds.xml cannot be combined with dds.security.mode: required; use the other keys instead of dds.xml");
  }
  return {};
}

}  // namespace

Status PublishConfig::validate() const {
  if (!native && !ros2.enabled) {
    return fail(ErrorCode::kInvalidConfig,
                "dds.native and dds.ros2.enabled are both false; nothing would be published");
  }
  constexpr std::size_t kMaxInterface = 15;  // IFNAMSIZ - 1.
  return first_failure({check_range("dds.domain", domain, 0, kMaxDomain),
                        check_name("dds.interface", interface, "_.:@-", kMaxInterface), check_peers(peers),
                        check_name("dds.device", device, "_.-", kMaxDeviceLength),
                        check_range("dds.bytes_per_second", bytes_per_second, 10'000, 1'000'000'000),
                        check_range("dds.piece_bytes", piece_bytes, kMinPieceBytes, kMaxPieceBytes),
                        check_range("dds.max_points", max_points, 0, kMaxPoints),
                        check_range("dds.trajectory_queue", trajectory_queue, 64, 1'000'000),
                        check_range("dds.log_lines_per_minute", log_lines_per_minute, 0, 6000),
                        check_range("max_objects", max_objects, 1, kMaxObjects), check_prefix(ros2.prefix),
                        check_frames(ros2), check_security(security), check_xml(*this)});
}

}  // namespace kinetrace::publishing

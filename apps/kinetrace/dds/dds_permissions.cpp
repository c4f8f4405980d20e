#include "dds/dds_permissions.hpp"

#include <array>
#include <ctime>
#include <vector>

#include "kinetrace/publishing/publish_config.hpp"
#include "kinetrace/publishing/topics.hpp"

namespace kinetrace::app {
namespace {

using Topics = std::vector<std::string>;

constexpr std::string_view kXml = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
constexpr std::string_view kSchemas =
    "<dds xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" "
    "xsi:noNamespaceSchemaLocation=\"http://www.omg.org/spec/DDS-SECURITY/20170901/";

std::string domains() {
  return "<domains><id_range><min>0</min><max>" + std::to_string(publishing::PublishConfig::kMaxDomain) +
         "</max></id_range></domains>";
}

Topics results(std::string_view ros_prefix) {
  namespace topics = publishing::topics;
  const std::string own = "rt/" + std::string(ros_prefix) + (ros_prefix.empty() ? "" : "/");
  Topics all{topics::kCameraPose,  topics::kObjects, topics::kTrajectories, topics::kPoints, topics::kHealth,
             topics::kCalibration, "rt/tf",          "rt/tf_static",        "rt/diagnostics"};
  for (const char* name : {"odometry", "detections", "markers", "trajectories", "points", "fix", "object_fixes"}) {
    all.push_back(own + name);
  }
  return all;
}

// Infrastructure topics of every ROS 2 node; without them no node starts.
const Topics kRosHousekeeping{"ros_discovery_info", "rt/rosout", "rt/parameter_events", "rq/*", "rr/*"};

Topics operator+(Topics left, const Topics& right) {
  left.insert(left.end(), right.begin(), right.end());
  return left;
}

std::string list(std::string_view tag, const Topics& topics) {
  const std::string name(tag);
  std::string text = "<" + name + "><topics>";
  for (const std::string& topic : topics) {
    text += "\n  <topic>" + topic + "</topic>";
  }
  return text + "\n</topics></" + name + ">\n";
}

std::string rules(DdsRole role, std::string_view ros_prefix) {
  const Topics masks{publishing::topics::kInstanceMasks};
  const Topics requests{publishing::topics::kMaskRequest};
  switch (role) {
    case DdsRole::kDevice: return list("publish", results(ros_prefix) + requests) + list("subscribe", masks);
    case DdsRole::kSegmenter: return list("publish", masks) + list("subscribe", results(ros_prefix) + requests);
    case DdsRole::kViewer: break;
  }
  return list("publish", kRosHousekeeping) + list("subscribe", results(ros_prefix) + kRosHousekeeping);
}

}  // namespace

std::string utc_text(std::int64_t time_s) {
  const auto time = static_cast<std::time_t>(time_s);
  std::tm utc{};
  std::array<char, 32> text{};
  gmtime_r(&time, &utc);
  std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%S", &utc);
  return text.data();
}

std::string governance_xml() {
  // Metadata protection encrypts whole submessages, so the data in them needs no second layer.
  return std::string(kXml) + std::string(kSchemas) +
         "omg_shared_ca_governance.xsd\">\n<domain_access_rules><domain_rule>" + domains() +
         "\n<allow_unauthenticated_participants>false</allow_unauthenticated_participants>"
         "\n<enable_join_access_control>true</enable_join_access_control>"
         "\n<discovery_protection_kind>ENCRYPT</discovery_protection_kind>"
         "\n<liveliness_protection_kind>ENCRYPT</liveliness_protection_kind>"
         "\n<rtps_protection_kind>SIGN</rtps_protection_kind>"
         "\n<topic_access_rules><topic_rule><topic_expression>*</topic_expression>"
         "\n<enable_discovery_protection>true</enable_discovery_protection>"
         "\n<enable_liveliness_protection>true</enable_liveliness_protection>"
         "\n<enable_read_access_control>true</enable_read_access_control>"
         "\n<enable_write_access_control>true</enable_write_access_control>"
         "\n<metadata_protection_kind>ENCRYPT</metadata_protection_kind>"
         "\n<data_protection_kind>NONE</data_protection_kind>"
         "\n</topic_rule></topic_access_rules></domain_rule></domain_access_rules></dds>\n";
}

std::string permissions_xml(std::string_view name, DdsRole role, std::string_view ros_prefix,
                            const Validity& validity) {
  const std::string who(name);
  return std::string(kXml) + std::string(kSchemas) + "omg_shared_ca_permissions.xsd\">\n<permissions><grant name=\"" +
         who + "\">\n<subject_name>CN=" + who + "</subject_name>\n<validity><not_before>" + utc_text(validity.begin_s) +
         "</not_before><not_after>" + utc_text(validity.end_s) + "</not_after></validity>\n<allow_rule>" + domains() +
         "\n" + rules(role, ros_prefix) + "</allow_rule>\n<default>DENY</default></grant></permissions></dds>\n";
}

}  // namespace kinetrace::app

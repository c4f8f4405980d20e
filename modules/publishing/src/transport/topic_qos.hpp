// Quality of service per kind of topic; the module's README has the table and the reasons.
#pragma once

#include <cstdint>

#include "link/dds_entity.hpp"

namespace kinetrace::publishing {

/// Encoding of messages: that of ROS 2, or one that allows new members.
enum class Encoding : std::uint8_t { kRos, kNative };

/// KEEP_LAST, and RELIABLE for all writers: a stalled reader never blocks a writer, and both kinds of readers match.
struct TopicQos {
  Encoding encoding = Encoding::kNative;
  std::int32_t depth = 1;
  bool keeps_last = false;   ///< TRANSIENT_LOCAL: late readers receive the history.
  bool best_effort = false;  ///< A reader that matches both kinds of writers, for ROS 2 sensors.
};

[[nodiscard]] Qos make_qos(const TopicQos& qos);

}  // namespace kinetrace::publishing

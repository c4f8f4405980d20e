// Quality of service per kind of topic; the module's README has the table and the reasons.
#pragma once

#include <cstdint>

#include "link/dds_entity.hpp"

namespace kinetrace::publishing {

/// How a message is encoded: what ROS 2 reads, or what may grow by members.
enum class Encoding : std::uint8_t { kRos, kNative };

/// KEEP_LAST, and RELIABLE for all that writes: a reader that stopped never holds a writer, and both kinds of readers
/// match.
struct TopicQos {
  Encoding encoding = Encoding::kNative;
  std::int32_t depth = 1;
  bool keeps_last = false;   ///< TRANSIENT_LOCAL: readers that come later get what is in the history.
  bool best_effort = false;  ///< A reader that matches both kinds of writers, as sensors of ROS 2 have them.
};

[[nodiscard]] Qos make_qos(const TopicQos& qos);

}  // namespace kinetrace::publishing

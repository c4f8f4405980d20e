// Quality of service per kind of topic; the module's README has the table and the reasons.
#pragma once

#include <cstdint>

#include "link/dds_entity.hpp"

namespace kinetrace::publishing {

/// How a message is encoded: what ROS 2 reads, or what may grow by members.
enum class Encoding : std::uint8_t { kRos, kNative };

/// Always RELIABLE and KEEP_LAST: a reader that stopped never holds a writer, and both kinds of readers match.
struct TopicQos {
  Encoding encoding = Encoding::kNative;
  std::int32_t depth = 1;
  bool keeps_last = false;  ///< TRANSIENT_LOCAL: readers that come later get what is in the history.
};

[[nodiscard]] Qos make_qos(const TopicQos& qos);

}  // namespace kinetrace::publishing

// Receives ROS 2 topics as serialized bytes, for recordings.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "kinetrace/core/export.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/publishing/link.hpp"

namespace kinetrace::publishing {

struct RosTopicDescription {
  std::string name;        ///< "/kinetrace/odometry".
  std::string type;        ///< "nav_msgs/msg/Odometry".
  std::string definition;  ///< See ros_definition.
  std::string qos;         ///< Offered quality of service, in YAML for players of recordings.
};

/// A received message. The bytes are valid during the call that receives them.
struct RosMessage {
  std::size_t topic = 0;           ///< Index in the topics.
  std::int64_t sent_ns = 0;        ///< System clock (Unix) of the sender.
  std::span<const std::byte> cdr;  ///< With its four-byte header.
};

/// Reads all topics that Kinetrace publishes to ROS 2; of /tf, /tf_static and /diagnostics also messages of other
/// nodes. Memory is bounded by the depth of the topics and the largest message.
class KINETRACE_API RosReader {
 public:
  /// `prefix` is that of the sender (dds.ros2.prefix). `link` must outlive it.
  RosReader(Link& link, const std::string& prefix);
  RosReader(const RosReader&) = delete;
  RosReader& operator=(const RosReader&) = delete;
  ~RosReader();

  [[nodiscard]] const std::vector<RosTopicDescription>& topics() const noexcept;

  /// Passes on all messages since the last call, topic by topic; does not wait, see Link::wait. An error of `visit`
  /// ends the call. Errors: those of `visit`; kIo if the DDS library refuses a topic.
  [[nodiscard]] Status take(const std::function<Status(const RosMessage&)>& visit);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace kinetrace::publishing

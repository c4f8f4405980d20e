// Writes MCAP files (https://mcap.dev/spec, version 0) for ROS 2 tools.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "kinetrace/core/export.hpp"
#include "kinetrace/core/result.hpp"

namespace kinetrace::recording {

struct McapTopic {
  std::string name;        ///< ROS 2 name: "/kinetrace/odometry".
  std::string type;        ///< "nav_msgs/msg/Odometry".
  std::string definition;  ///< The .msg text with those of all nested types. The first definition of a type counts.
  std::vector<std::pair<std::string, std::string>> metadata{};  ///< Of the channel: "offered_qos_profiles".
};

struct McapCounters {
  std::uint64_t messages = 0;
  std::uint64_t bytes = 0;  ///< Current size of the file.
};

/// Writes the profile "ros2": messages are serialized CDR with its four-byte header, and are not inspected.
///
/// Every message is a chunk of its own with a checksum, passed to the system before `write` returns. A file truncated
/// anywhere (a kill, a full disk, a power failure after the system's write) is readable up to its last whole message,
/// by readers that scan from the beginning; a finished file also has an index. Cost: about 170 bytes a message. The
/// index is built from the file itself, so memory is bounded by the largest message.
class KINETRACE_API McapWriter {
 public:
  /// Creates the file. `library` names the writing program. Errors: kIo (it exists already, no permission, disk full).
  [[nodiscard]] static Result<McapWriter> create(const std::filesystem::path& path, std::string_view library);
  McapWriter(McapWriter&&) noexcept;
  McapWriter& operator=(McapWriter&&) noexcept;
  /// Closes the file without an index if it was not finished.
  ~McapWriter();

  /// Returns the channel for `write`. Errors: kIo, kCapacity (65535 channels).
  [[nodiscard]] Result<std::uint16_t> add_topic(const McapTopic& topic);

  /// Writes one message. Times of reception and of sending are Unix nanoseconds. After an error the file ends with the
  /// previous message, and every further call returns the same error. Errors: kIo, kInvalidArgument (no such channel).
  [[nodiscard]] Status write(std::uint16_t channel, std::int64_t received_ns, std::int64_t sent_ns,
                             std::span<const std::byte> cdr);

  /// Writes the index and ends the file; nothing can be written afterwards. Errors: kIo.
  [[nodiscard]] Status finish();

  [[nodiscard]] McapCounters counters() const noexcept;

 private:
  struct Impl;
  explicit McapWriter(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace kinetrace::recording

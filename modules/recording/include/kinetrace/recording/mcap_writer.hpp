// Messages into an MCAP file (https://mcap.dev/spec, version 0) that ROS 2 tools open.
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
  std::string name;        ///< As ROS 2 says it: "/kinetrace/odometry".
  std::string type;        ///< "nav_msgs/msg/Odometry".
  std::string definition;  ///< The .msg text with those of all types in it. The first one of a type counts.
  std::vector<std::pair<std::string, std::string>> metadata{};  ///< Of the channel: "offered_qos_profiles".
};

struct McapCounters {
  std::uint64_t messages = 0;
  std::uint64_t bytes = 0;  ///< Of the file so far.
};

/// Writes the profile "ros2": messages are CDR with its four-byte header, as they travelled, and are not looked at.
///
/// Every message is a chunk of its own, with its checksum, and is given to the system before `write` returns. So a file
/// that ends anywhere (a kill, a full disk, a loss of power after the system wrote it out) is read up to its last whole
/// message, by readers that follow the file from its beginning; and a file that was finished has an index as well. The
/// price is about 170 bytes a message. The index is made from the file itself, so memory does not grow: it is that of
/// the largest message.
class KINETRACE_API McapWriter {
 public:
  /// Makes the file. `library` names the program that writes. Errors: kIo (it exists already, no permission, disk
  /// full).
  [[nodiscard]] static Result<McapWriter> create(const std::filesystem::path& path, std::string_view library);
  McapWriter(McapWriter&&) noexcept;
  McapWriter& operator=(McapWriter&&) noexcept;
  /// Closes the file without an index if it was not finished.
  ~McapWriter();

  /// Returns the channel for `write`. Errors: kIo, kCapacity (65535 channels).
  [[nodiscard]] Result<std::uint16_t> add_topic(const McapTopic& topic);

  /// One message. Times are Unix nanoseconds: when it was received, and when it was sent. After an error the file ends
  /// with the message before, and every further call says the same. Errors: kIo, kInvalidArgument (no such channel).
  [[nodiscard]] Status write(std::uint16_t channel, std::int64_t received_ns, std::int64_t sent_ns,
                             std::span<const std::byte> cdr);

  /// Index and end of the file; nothing can be written afterwards. Errors: kIo.
  [[nodiscard]] Status finish();

  [[nodiscard]] McapCounters counters() const noexcept;

 private:
  struct Impl;
  explicit McapWriter(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace kinetrace::recording

// Health for ROS 2: one status with reasons and counters as values.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/frame_result.hpp"
#include "kinetrace/core/health.hpp"
#include "kinetrace/publishing/published_frame.hpp"
#include "kinetrace/publishing/publisher.hpp"
#include "ros2.h"

namespace kinetrace::publishing {

class RosDiagnostics {
 public:
  RosDiagnostics() = default;
  explicit RosDiagnostics(Arena& arena);

  /// The message refers to storage here and to `device`.
  [[nodiscard]] diagnostic_msgs_msg_dds__DiagnosticArray_ fill(const PublishedHealth& health,
                                                               const PublishCounters& sent, const std::string& device,
                                                               const std_msgs_msg_dds__Header_& header) noexcept;

 private:
  static constexpr std::size_t kMaxValues =
      1 + kHealthReasonCount + kFrameCounterNames.size() + kPublishCounterNames.size();
  struct Storage {
    std::array<diagnostic_msgs_msg_dds__KeyValue_, kMaxValues> values;
    std::array<std::array<char, 24>, kMaxValues> texts;
    diagnostic_msgs_msg_dds__DiagnosticStatus_ status;
  };
  void add(std::string_view key, std::uint64_t value) noexcept;
  void add(std::string_view key, std::string_view value) noexcept;

  Storage* storage_ = nullptr;  ///< Null while measuring the size.
  std::size_t count_ = 0;
};

}  // namespace kinetrace::publishing

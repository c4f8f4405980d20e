// Markers for RViz: box, velocity and name of each object.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/frame_result.hpp"
#include "ros2.h"

namespace kinetrace::publishing {

/// Markers of a few objects, refilled for each message. They expire after `kLifetime_s`, so that removed objects need
/// no message.
class RosMarkers {
 public:
  static constexpr std::size_t kPerObject = 3;
  static constexpr int kLifetime_s = 1;

  RosMarkers() = default;
  RosMarkers(Arena& arena, std::size_t max_objects);

  void clear() noexcept { count_ = 0; }
  /// At most `max_objects` times after clear(). The header's text must outlive the message.
  void add(const ObjectResult& object, const std_msgs_msg_dds__Header_& header) noexcept;
  [[nodiscard]] std::span<visualization_msgs_msg_dds__Marker_> markers() noexcept { return markers_.first(count_); }

 private:
  struct Storage {
    std::array<char, 32> label;
    std::array<geometry_msgs_msg_dds__Point_, 2> arrow;
  };
  [[nodiscard]] visualization_msgs_msg_dds__Marker_& next(const ObjectResult& object,
                                                          const std_msgs_msg_dds__Header_& header, const char* ns,
                                                          int type) noexcept;

  std::span<visualization_msgs_msg_dds__Marker_> markers_;
  std::span<Storage> storage_;  ///< By marker.
  std::size_t count_ = 0;
};

}  // namespace kinetrace::publishing

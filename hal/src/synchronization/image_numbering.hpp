// Numbers images so that lost ones leave gaps.
#pragma once

#include <cstdint>
#include <optional>

namespace kinetrace::hal {

/// Numbers the images of one device; lost images leave gaps. By the driver's sequence if that counts losses, else by
/// time, in whole periods.
class ImageNumbering {
 public:
  explicit ImageNumbering(std::int64_t period_ns) : period_ns_(period_ns) {}

  /// Call it when the driver restarts its sequence.
  void restart() noexcept { sequence_.reset(); }
  /// The next image's number. `sequence`: none if it does not count losses. `time_ns`: none if it is no evidence
  /// (damaged, repeated or externally triggered images).
  std::int64_t next(std::optional<std::int64_t> sequence, std::optional<std::int64_t> time_ns) noexcept;
  [[nodiscard]] std::int64_t number() const noexcept { return number_; }

 private:
  struct Timed {
    std::int64_t number = 0;
    std::int64_t time_ns = 0;
  };

  std::int64_t period_ns_;
  std::int64_t number_ = 0;
  std::optional<std::int64_t> sequence_;
  std::optional<Timed> timed_;  ///< The last image with a time.
};

}  // namespace kinetrace::hal

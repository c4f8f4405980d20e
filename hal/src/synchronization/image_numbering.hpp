// Which images of a device never came.
#pragma once

#include <cstdint>
#include <optional>

namespace kinetrace::hal {

/// Numbers the images of one device as they were due: the numbers of those that never came are left out. By the
/// driver's sequence where that counts losses, else by time, in whole periods.
class ImageNumbering {
 public:
  explicit ImageNumbering(std::int64_t period_ns) : period_ns_(period_ns) {}

  /// The driver counts anew from here on.
  void restart() noexcept { sequence_.reset(); }
  /// The next image's number. `sequence`: none where it does not count losses. `time_ns`: none where it says nothing
  /// (of a damaged or repeated image, or one that was triggered from outside).
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
  std::optional<Timed> timed_;  ///< The last image that had a time.
};

}  // namespace kinetrace::hal

// Unwraps frame numbers of drivers, which wrap at 2^32.
#pragma once

#include <cstdint>
#include <optional>

namespace kinetrace::hal {

/// Continues a 32-bit number beyond its range: each number is the one nearest to its predecessor.
class SequenceUnwrapper {
 public:
  [[nodiscard]] std::int64_t unwrap(std::uint32_t sequence) noexcept {
    // The difference modulo 2^32, as a signed number, is the shortest step.
    last_ = last_ ? *last_ + static_cast<std::int32_t>(sequence - static_cast<std::uint32_t>(*last_)) : sequence;
    return *last_;
  }
  void reset() noexcept { last_.reset(); }

 private:
  std::optional<std::int64_t> last_;
};

}  // namespace kinetrace::hal

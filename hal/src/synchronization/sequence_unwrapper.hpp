// Frame numbers of drivers, which wrap at 2^32.
#pragma once

#include <cstdint>
#include <optional>

namespace kinetrace::hal {

/// Continues a 32-bit number beyond its range: each number is taken as the one nearest to the number before.
class SequenceUnwrapper {
 public:
  [[nodiscard]] std::int64_t unwrap(std::uint32_t sequence) noexcept {
    // The difference modulo 2^32, read as signed, is the shortest way round.
    last_ = last_ ? *last_ + static_cast<std::int32_t>(sequence - static_cast<std::uint32_t>(*last_)) : sequence;
    return *last_;
  }
  void reset() noexcept { last_.reset(); }

 private:
  std::optional<std::int64_t> last_;
};

}  // namespace kinetrace::hal

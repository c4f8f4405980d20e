// Counts heap allocations, own and foreign libraries' apart, so that "no allocation after start" is measured, not
// assumed.
#pragma once

#include <cstdint>

#include "kinetrace/core/export.hpp"

namespace kinetrace {

/// Marks the calling thread as inside a foreign library (OpenCV, libspng, Ceres...) until destroyed. Allocations during
/// that time count as foreign, and so do all of a thread started during it. Cheap: one thread-local increment.
class KINETRACE_API ForeignCall {
 public:
  ForeignCall() noexcept;
  ForeignCall(const ForeignCall&) = delete;
  ForeignCall& operator=(const ForeignCall&) = delete;
  ~ForeignCall();
};

/// Totals since the process began. Zero unless the program links the interposer (target
/// kinetrace_allocation_interposer).
struct AllocationCounts {
  std::uint64_t own = 0;
  std::uint64_t foreign = 0;
};
[[nodiscard]] KINETRACE_API AllocationCounts allocation_counts() noexcept;
/// Of the calling thread alone.
[[nodiscard]] KINETRACE_API AllocationCounts thread_allocation_counts() noexcept;
/// True if malloc is interposed in this program, that is, if the counts mean anything.
[[nodiscard]] KINETRACE_API bool allocation_counting_available() noexcept;

namespace detail {
[[nodiscard]] bool in_foreign_call() noexcept;
void count_allocation() noexcept;
void announce_interposer() noexcept;
}  // namespace detail

}  // namespace kinetrace

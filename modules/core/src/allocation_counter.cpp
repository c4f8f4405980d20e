#include "kinetrace/core/allocation_counter.hpp"

#include <atomic>

namespace kinetrace {
namespace {

// Relaxed everywhere: these are statistics, they order nothing.
std::atomic<std::uint64_t> own_count{0};
std::atomic<std::uint64_t> foreign_count{0};
std::atomic<bool> interposed{false};
// initial-exec: the default model may call malloc on first use, from inside malloc.
[[gnu::tls_model("initial-exec")]] thread_local int foreign_depth = 0;
[[gnu::tls_model("initial-exec")]] thread_local AllocationCounts of_thread{};

}  // namespace

ForeignCall::ForeignCall() noexcept {
  ++foreign_depth;
}
ForeignCall::~ForeignCall() {
  --foreign_depth;
}

AllocationCounts allocation_counts() noexcept {
  return {own_count.load(std::memory_order_relaxed), foreign_count.load(std::memory_order_relaxed)};
}

AllocationCounts thread_allocation_counts() noexcept {
  return of_thread;
}

bool allocation_counting_available() noexcept {
  return interposed.load(std::memory_order_relaxed);
}

bool detail::in_foreign_call() noexcept {
  return foreign_depth > 0;
}

void detail::count_allocation() noexcept {
  const bool is_foreign = in_foreign_call();
  (is_foreign ? foreign_count : own_count).fetch_add(1, std::memory_order_relaxed);
  ++(is_foreign ? of_thread.foreign : of_thread.own);
}

void detail::announce_interposer() noexcept {
  interposed.store(true, std::memory_order_relaxed);
}

}  // namespace kinetrace

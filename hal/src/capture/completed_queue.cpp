#include "capture/completed_queue.hpp"

#include <algorithm>
#include <sys/eventfd.h>
#include <unistd.h>

namespace kinetrace::hal {

CompletedQueue::CompletedQueue(std::size_t capacity) : event_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
  items_.reserve(capacity);
}

void CompletedQueue::push(const Item& item) noexcept {
  const std::lock_guard lock(mutex_);
  if (items_.size() < items_.capacity()) {
    items_.push_back(item);
    set_event();
  }
}

std::optional<CompletedQueue::Item> CompletedQueue::pop() noexcept {
  const std::lock_guard lock(mutex_);
  const auto first = std::min_element(items_.begin(), items_.end(),
                                      [](const Item& a, const Item& b) { return a.sequence < b.sequence; });
  if (first == items_.end()) {
    return std::nullopt;
  }
  const Item item = *first;
  items_.erase(first);
  clear_event_if_idle();
  return item;
}

void CompletedQueue::end() noexcept {
  const std::lock_guard lock(mutex_);
  ended_ = true;
  set_event();
}

bool CompletedQueue::ended() const noexcept {
  const std::lock_guard lock(mutex_);
  return ended_;
}

void CompletedQueue::clear() noexcept {
  const std::lock_guard lock(mutex_);
  items_.clear();
  clear_event_if_idle();
}

void CompletedQueue::set_event() noexcept {
  const std::uint64_t one = 1;
  // Fails only if the counter is full; then the descriptor is readable anyway.
  [[maybe_unused]] const ssize_t written = write(event_.get(), &one, sizeof one);
}

void CompletedQueue::clear_event_if_idle() noexcept {
  if (items_.empty() && !ended_) {
    std::uint64_t count = 0;
    // Fails only if it is not readable anyway.
    [[maybe_unused]] const ssize_t got = read(event_.get(), &count, sizeof count);
  }
}

}  // namespace kinetrace::hal

// Queue of completed images between the thread of the source and its consumer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <optional>
#include <vector>

#include "util/owned_fd.hpp"

namespace kinetrace::hal {

/// Ordered by sequence, not by completion. `wait_fd` is readable while the queue has items or after the source has
/// ended. Never allocates after construction.
class CompletedQueue {
 public:
  struct Item {
    int slot = -1;
    std::int64_t sequence = 0;
  };

  /// `capacity`: the number of slots, each of which is in here at most once.
  explicit CompletedQueue(std::size_t capacity);

  void push(const Item& item) noexcept;
  /// The item with the lowest sequence.
  [[nodiscard]] std::optional<Item> pop() noexcept;
  /// The source will never push again.
  void end() noexcept;
  [[nodiscard]] bool ended() const noexcept;
  void clear() noexcept;

  [[nodiscard]] int wait_fd() const noexcept { return event_.get(); }

 private:
  void set_event() noexcept;
  void clear_event_if_idle() noexcept;

  mutable std::mutex mutex_;
  std::vector<Item> items_;
  bool ended_ = false;
  OwnedFd event_;
};

}  // namespace kinetrace::hal

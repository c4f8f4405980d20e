#include "alignment_thread.hpp"

#include <utility>

#include "live/clocks.hpp"

namespace kinetrace::map {

AlignmentThread::AlignmentThread(std::function<void()> on_done)
    : on_done_(std::move(on_done)), thread_([this] { work(); }) {}

AlignmentThread::~AlignmentThread() {
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  changed_.notify_one();
  thread_.join();
}

AlignmentTask* AlignmentThread::idle_task() noexcept {
  const std::lock_guard lock(mutex_);
  return state_ == State::kIdle ? &task_ : nullptr;
}

void AlignmentThread::begin() {
  {
    const std::lock_guard lock(mutex_);
    state_ = State::kAtWork;
  }
  changed_.notify_one();
}

std::optional<Result<geo::Alignment>> AlignmentThread::collect() {
  const std::lock_guard lock(mutex_);
  if (state_ != State::kDone) {
    return std::nullopt;
  }
  state_ = State::kIdle;
  return std::exchange(done_, std::nullopt);
}

void AlignmentThread::work() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return ends_ || state_ == State::kAtWork; });
    if (ends_) {
      return;
    }
    lock.unlock();
    const std::int64_t begin_ns = app::steady_time_ns();
    Result<geo::Alignment> aligned = geo::align(task_.path, task_.fixes, task_.config);
    const std::int64_t took_ns = app::steady_time_ns() - begin_ns;
    lock.lock();
    done_ = std::move(aligned);
    took_ns_ = took_ns;
    state_ = State::kDone;
    on_done_();
  }
}

}  // namespace kinetrace::map

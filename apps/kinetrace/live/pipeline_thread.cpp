#include "live/pipeline_thread.hpp"

#include <utility>

#include "kinetrace/core/image_view.hpp"

namespace kinetrace::app {
namespace {

constexpr int kIdle_ms = 200;
// Reserved length of file names; longer ones cost an allocation.
constexpr std::size_t kLongName = 256;

}  // namespace

std::size_t PipelineThread::required_bytes(const StereoGeometry& geometry) {
  return measure_bytes([&](Arena& arena) {
    for (int i = 0; i < 3; ++i) {
      static_cast<void>(carve(geometry, arena));
    }
  });
}

PipelineThread::Slot PipelineThread::carve(const StereoGeometry& geometry, Arena& arena) {
  Slot slot;
  for (MutableGrayView* view : {&slot.left, &slot.right}) {
    const auto pixels = arena.take<std::uint8_t>(static_cast<std::size_t>(geometry.width_px) *
                                                 static_cast<std::size_t>(geometry.height_px));
    *view = {pixels.data(), geometry.width_px, geometry.height_px, geometry.width_px};
  }
  slot.name.reserve(kLongName);
  return slot;
}

Result<std::unique_ptr<PipelineThread>> PipelineThread::create(const StereoGeometry& geometry, Process process,
                                                               Idle idle, Arena& arena) {
  std::unique_ptr<PipelineThread> made(new PipelineThread(geometry, std::move(process), std::move(idle), arena));
  if (arena.exhausted()) {
    return fail(ErrorCode::kCapacity, "the arena does not hold the frames that wait; size it from required_bytes");
  }
  if (!made->wake_event_.is_open()) {
    return fail(ErrorCode::kIo, "live mode needs one more open file than the process may have; raise its limit");
  }
  made->thread_ = std::thread([thread = made.get()] { thread->run(); });
  made->has_begun_.wait();  // Starting a thread allocates memory.
  return made;
}

PipelineThread::PipelineThread(const StereoGeometry& geometry, Process process, Idle idle, Arena& arena)
    : process_(std::move(process)), idle_(std::move(idle)), slots_([&] { return carve(geometry, arena); }) {}

Result<bool> PipelineThread::offer(const RectifiedPair& pair, std::int64_t exposed_ns) {
  if (const Status earlier = failure(); !earlier) {
    return Unexpected(earlier.error());
  }
  Slot& slot = slots_.slot();
  copy_image(pair.left, slot.left);
  copy_image(pair.right, slot.right);
  slot.name.assign(pair.name);
  slot.exposed_ns = exposed_ns;
  slot.pair = pair;
  slot.pair.name = slot.name;
  slot.pair.left = slot.left;
  slot.pair.right = slot.right;
  const bool was_left_out = slots_.publish();
  wake_event_.signal();
  return was_left_out;
}

Status PipelineThread::finish() noexcept {
  if (thread_.joinable()) {
    ends_ = true;
    wake_event_.signal();
    thread_.join();
  }
  return failure();
}

bool PipelineThread::process_newest() {
  const Slot* slot = slots_.fetch();
  if (slot == nullptr) {
    return false;
  }
  if (const Status processed = process_(slot->pair, slot->exposed_ns); !processed) {
    const std::lock_guard lock(mutex_);
    failure_ = processed.error();
  }
  return true;
}

void PipelineThread::run() {
  has_begun_.count_down();
  while (failure()) {
    const bool is_last_look = ends_;  // Read before looking: a pair offered before the end is processed.
    if (process_newest()) {
      continue;
    }
    if (is_last_look) {
      return;
    }
    wake_event_.wait(kIdle_ms);
    idle_();
  }
}

Status PipelineThread::failure() const {
  const std::lock_guard lock(mutex_);
  return failure_ ? Status(Unexpected(*failure_)) : Status{};
}

}  // namespace kinetrace::app

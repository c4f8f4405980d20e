#include "kinetrace/hal/fault_injector.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <thread>
#include <utility>

#include "util/deadline.hpp"
#include "util/messages.hpp"

namespace kinetrace::hal {
namespace {

// Grey value of the unfilled part of a buffer.
constexpr std::uint8_t kUnfilled = 0;

// Steele, Lea, Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014: the finaliser of SplitMix64.
std::uint64_t mixed(std::uint64_t x) noexcept {
  x += 0x9E3779B97F4A7C15ULL;
  x = (x ^ (x >> 30U)) * 0xBF58476D1CE4E5B9ULL;
  x = (x ^ (x >> 27U)) * 0x94D049BB133111EBULL;
  return x ^ (x >> 31U);
}

// In [0, 1), a function of seed, kind and frame.
double uniform_hash(std::uint64_t seed, FaultKind kind, std::int64_t number) noexcept {
  const std::uint64_t bits =
      mixed(mixed(seed ^ (static_cast<std::uint64_t>(kind) << 56U)) + static_cast<std::uint64_t>(number));
  return std::ldexp(static_cast<double>(bits >> 11U), -53);
}

}  // namespace

void FaultInjector::carve(int width_px, int height_px, Arena& arena, Storage& storage) {
  for (auto* pair : {&storage.modified, &storage.kept}) {
    for (MutableGrayView& image : *pair) {
      image = take_image<std::uint8_t>(arena, width_px, height_px);
    }
  }
  storage.last_right = take_image<std::uint8_t>(arena, width_px, height_px);
}

std::size_t FaultInjector::required_bytes(int width_px, int height_px) {
  return measure_bytes([&](Arena& arena) {
    Storage storage;
    carve(width_px, height_px, arena, storage);
  });
}

Result<std::unique_ptr<FaultInjector>> FaultInjector::create(std::unique_ptr<StereoCamera> camera, FaultPlan plan,
                                                             int width_px, int height_px, Arena& arena) {
  Storage storage;
  carve(width_px, height_px, arena, storage);
  if (arena.exhausted()) {
    return fail(ErrorCode::kCapacity, "the arena does not hold the fault injector; enlarge the memory budget");
  }
  return std::unique_ptr<FaultInjector>(new FaultInjector(std::move(camera), std::move(plan), storage));
}

FaultInjector::FaultInjector(std::unique_ptr<StereoCamera> camera, FaultPlan plan, const Storage& storage)
    : camera_(std::move(camera)), plan_(std::move(plan)), storage_(storage) {}

Status FaultInjector::start() {
  Status started = camera_->start();
  if (started) {
    forget();
    number_ = 0;
    own_ = {};
  }
  return started;
}

// Frames of one stream must not reach the next, nor be read: they may refer to buffers of the device.
void FaultInjector::forget() noexcept {
  state_.reset();
  gone_until_ = -1;
  has_last_right_ = false;
  waiting_.reset();
  held_back_.reset();
}

Status FaultInjector::stop() {
  if (state() == CameraState::kLost) {
    return fail(ErrorCode::kIllegalState, info().name + ": stop() is not allowed while the camera is lost");
  }
  forget();
  return camera_->stop();
}

void FaultInjector::close() noexcept {
  forget();
  camera_->close();
}

const Fault* FaultInjector::active(FaultKind kind, std::int64_t number) const noexcept {
  for (const Fault& fault : plan_.faults) {
    const std::int64_t last = kind == FaultKind::kClock ? std::numeric_limits<std::int64_t>::max() : fault.last;
    if (fault.kind == kind && number >= fault.first && number <= last &&
        (fault.probability >= 1.0 || uniform_hash(plan_.seed, kind, number) < fault.probability)) {
      return &fault;
    }
  }
  return nullptr;
}

Result<StereoFrame> FaultInjector::next(std::chrono::milliseconds timeout) {
  if (state_ == CameraState::kLost) {
    return fail(ErrorCode::kIllegalState, info().name + ": next() is not allowed while the camera is lost");
  }
  Result<StereoFrame> frame = produce(timeout);
  own_.frames_delivered += frame ? 1 : 0;
  return frame;
}

Result<StereoFrame> FaultInjector::produce(std::chrono::milliseconds timeout) {
  if (waiting_) {
    return *std::exchange(waiting_, std::nullopt);
  }
  const Deadline deadline(timeout);
  do {
    Result<StereoFrame> frame = camera_->next(deadline.left());
    if (!frame && frame.error().code == ErrorCode::kEndOfStream && held_back_) {
      return *std::exchange(held_back_, std::nullopt);  // The stream has ended: no frame follows.
    }
    if (!frame) {
      state_.reset();
      return frame;
    }
    const std::int64_t number = number_++;
    if (number <= gone_until_) {
      continue;
    }
    if (active(FaultKind::kDrop, number) != nullptr) {
      ++own_.gaps;
      continue;
    }
    if (const Fault* fault = active(FaultKind::kUnplug, number)) {
      return unplug(*fault);
    }
    if (active(FaultKind::kStuck, number) != nullptr) {
      return stall();
    }
    if (const Fault* fault = active(FaultKind::kSlow, number)) {
      std::this_thread::sleep_for(std::chrono::duration<double, std::milli>(fault->value));
    }
    state_.reset();
    if (!has_room_for(*frame)) {
      return frame;
    }
    apply_faults(*frame, number);
    if (active(FaultKind::kReorder, number) != nullptr && !held_back_) {
      held_back_ = keep(*frame);
      continue;
    }
    waiting_ = std::exchange(held_back_, std::nullopt);
    if (!waiting_ && active(FaultKind::kDuplicate, number) != nullptr) {
      waiting_ = *frame;  // Valid: the camera keeps its buffers until its next call.
    }
    return frame;
  } while (!deadline.is_over());
  return fail(ErrorCode::kTimeout, info().name + ": no image in time (injected fault)");
}

Result<StereoFrame> FaultInjector::unplug(const Fault& fault) {
  state_ = CameraState::kLost;
  gone_until_ = fault.probability < 1.0 ? number_ - 1 : fault.last;
  attempts_left_ = static_cast<int>(fault.value);
  ++own_.losses;
  return fail(ErrorCode::kDisconnected, info().name + ": unplugged (injected fault)");
}

Result<StereoFrame> FaultInjector::stall() {
  if (state_ != CameraState::kStalled) {
    ++own_.stalls;
  }
  state_ = CameraState::kStalled;
  return fail(ErrorCode::kTimeout, info().name + ": no image (injected fault)");
}

Status FaultInjector::recover() {
  if (state_ != CameraState::kLost) {
    return camera_->recover();
  }
  if (attempts_left_ > 0) {
    --attempts_left_;
    return fail(ErrorCode::kDisconnected, info().name + ": still unplugged (injected fault)");
  }
  state_ = CameraState::kRecovering;
  ++own_.recoveries;
  return {};
}

void FaultInjector::apply_faults(StereoFrame& frame, std::int64_t number) {
  lag_right(frame, active(FaultKind::kDesync, number) != nullptr);
  if (const Fault* fault = active(FaultKind::kCorrupt, number)) {
    cut_off(frame, number, fault->value);
  }
  if (active(FaultKind::kSize, number) != nullptr) {
    for (GrayView* image : {&frame.left, &frame.right}) {
      image->width /= 2;
      image->height /= 2;
    }
  }
  if (const Fault* fault = active(FaultKind::kClock, number)) {
    frame.timestamp_ns += std::llround(fault->value * 1e9);
  }
}

void FaultInjector::cut_off(StereoFrame& frame, std::int64_t number, double percent) {
  const bool is_left = uniform_hash(plan_.seed, FaultKind::kCorrupt, ~number) < 0.5;
  GrayView& image = is_left ? frame.left : frame.right;
  const MutableGrayView modified = storage_.modified[is_left ? 0 : 1];
  // A delayed view has been copied already.
  if (image.data != modified.data) {
    copy_image(image, modified);
  }
  const int arrived = static_cast<int>(image.height * (1.0 - percent / 100.0));
  for (int y = arrived; y < image.height; ++y) {
    std::fill_n(modified.row(y), modified.width, kUnfilled);
  }
  image = modified;
}

// Copies only if the plan delays a view.
void FaultInjector::lag_right(StereoFrame& frame, bool lags) {
  const bool ever = std::any_of(plan_.faults.begin(), plan_.faults.end(),
                                [](const Fault& fault) { return fault.kind == FaultKind::kDesync; });
  if (!ever) {
    return;
  }
  const MutableGrayView before = storage_.modified[1];
  if (has_last_right_) {
    copy_image<std::uint8_t>(storage_.last_right, before);
  }
  copy_image(frame.right, storage_.last_right);
  if (lags && has_last_right_) {
    frame.right = before;
  }
  has_last_right_ = true;
}

bool FaultInjector::has_room_for(const StereoFrame& frame) const noexcept {
  const MutableGrayView& room = storage_.last_right;
  return frame.left.width == room.width && frame.left.height == room.height && frame.right.width == room.width &&
         frame.right.height == room.height;
}

StereoFrame FaultInjector::keep(const StereoFrame& frame) {
  const auto copy = [](GrayView image, const MutableGrayView& memory) {
    const MutableGrayView target{memory.data, image.width, image.height, memory.stride};
    copy_image(image, target);
    return target;
  };
  StereoFrame kept = frame;
  kept.left = copy(frame.left, storage_.kept[0]);
  kept.right = copy(frame.right, storage_.kept[1]);
  return kept;
}

const CameraCounters& FaultInjector::counters() const noexcept {
  sum_ = camera_->counters();
  sum_.frames_delivered = own_.frames_delivered;
  sum_.gaps += own_.gaps;
  sum_.stalls += own_.stalls;
  sum_.losses += own_.losses;
  sum_.recoveries += own_.recoveries;
  return sum_;
}

}  // namespace kinetrace::hal

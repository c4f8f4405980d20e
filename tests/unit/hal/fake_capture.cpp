#include "fake_capture.hpp"

#include <algorithm>
#include <cstring>
#include <optional>

namespace kinetrace::hal::test {

class FakeDevice final : public CaptureDevice {
 public:
  FakeDevice(FakeMachine& machine, FakeSensor& sensor, CaptureConfig config)
      : machine_(machine),
        sensor_(sensor),
        config_(std::move(config)),
        busy_(static_cast<std::size_t>(config_.buffers)) {
    machine_.devices_.push_back(this);
  }
  ~FakeDevice() override {
    sensor_.in_use = 0;
    std::erase(machine_.devices_, this);
  }

  Status open() override {
    if (!sensor_.plugged) {
      return fail(ErrorCode::kNotFound, config_.device + ": no such device");
    }
    ++sensor_.opened;
    info_ = {.name = "fake at " + sensor_.path,
             .stable_id = sensor_.stable_id,
             .serial = sensor_.serial,
             .format = config_.format,
             .width_px = sensor_.width_px > 0 ? sensor_.width_px : config_.width_px,
             .height_px = config_.height_px,
             .stride_bytes = config_.width_px + 16,
             .rate_hz = sensor_.tells_rate ? 1e9 / static_cast<double>(sensor_.period_ns) : 0.0,
             .exposure_us = sensor_.exposure_us,
             .gain = {},
             .timestamp_kind = sensor_.timestamp_kind,
             .sequence_counts_losses = sensor_.sequence_counts_losses};
    const auto bytes = static_cast<std::size_t>(info_.stride_bytes) * static_cast<std::size_t>(info_.height_px);
    pixels_.assign(busy_.size(), std::vector<std::byte>(bytes));
    return {};
  }

  Status start() override {
    ++sensor_.started;
    sensor_.stream_broken = sensor_.never_mends;
    sensor_.in_use = 0;
    std::fill(busy_.begin(), busy_.end(), false);
    // The shot after now.
    const std::int64_t since = machine_.now_ns_ - sensor_.phase_ns;
    next_ = since < 0 ? 0 : since / sensor_.period_ns + 1;
    first_ = next_;
    coming_.reset();
    filled_.clear();
    filled_.reserve(busy_.size());
    return {};
  }

  Result<CapturedImage> next(std::chrono::milliseconds /*timeout*/) override {
    if (!sensor_.plugged) {
      return fail(ErrorCode::kDisconnected, "device has gone");
    }
    if (sensor_.stream_broken) {
      return fail(ErrorCode::kIo, "stream error");
    }
    catch_up();
    if (filled_.empty()) {
      return fail(ErrorCode::kTimeout, "nothing");
    }
    const Shot shot = filled_.front();
    filled_.erase(filled_.begin());
    machine_.pass(sensor_.taking_ns);
    const auto free = std::find(busy_.begin(), busy_.end(), false);
    const auto slot = static_cast<std::size_t>(free - busy_.begin());
    *free = true;
    sensor_.most_in_use = std::max(sensor_.most_in_use, ++sensor_.in_use);
    paint(shot, slot);
    const std::span<const std::byte> bytes(pixels_[slot]);
    return CapturedImage{static_cast<int>(slot),
                         shot.sequence,
                         shot.stamp_ns,
                         shot.damaged,
                         shot.cut ? bytes.first(bytes.size() / 2) : bytes,
                         sensor_.given_exposure_ns,
                         std::nullopt};
  }

  void release(int slot) noexcept override {
    catch_up();
    if (busy_[static_cast<std::size_t>(slot)]) {
      busy_[static_cast<std::size_t>(slot)] = false;
      --sensor_.in_use;
    }
  }
  Status stop() override { return {}; }
  void close() noexcept override {}
  // No descriptor, but a number by which FakeMachine knows it.
  int wait_fd() const noexcept override { return id_; }
  const CaptureInfo& info() const noexcept override { return info_; }

  // Time at which next() has a result; none: never.
  std::optional<std::int64_t> ready_ns() {
    if (!sensor_.plugged || sensor_.stream_broken || sensor_.falsely_ready) {
      return machine_.now_ns_;
    }
    catch_up();
    if (!filled_.empty()) {
      return filled_.front().arrival_ns;
    }
    return sensor_.mute ? std::nullopt : std::optional(coming().arrival_ns);
  }

 private:
  // The next shot that is not lost.
  const Shot& coming() {
    while (!coming_ || coming_->lost) {
      const std::int64_t stamp_ns = sensor_.phase_ns + next_ * sensor_.period_ns;
      coming_ = Shot{next_, stamp_ns, stamp_ns + sensor_.latency_ns, next_ - first_};
      ++next_;
      if (sensor_.script) {
        sensor_.script(*coming_);
      }
    }
    return *coming_;
  }
  // Catches up with the driver: arrived images fill its buffers, images without a buffer are lost.
  void catch_up() {
    while (coming().arrival_ns <= machine_.now_ns_) {
      const auto in_use = static_cast<std::size_t>(std::count(busy_.begin(), busy_.end(), true));
      if (!sensor_.mute && filled_.size() + in_use < busy_.size()) {
        filled_.push_back(*coming_);
      }
      coming_.reset();
    }
  }
  void paint(const Shot& shot, std::size_t slot) {
    const auto value = static_cast<int>((shot.number - sensor_.lag_shots) % 256);
    std::memset(pixels_[slot].data(), value, pixels_[slot].size());
    if (!sensor_.side_by_side) {
      return;
    }
    const auto half = static_cast<std::size_t>(info_.width_px / 2);
    for (std::size_t y = 0; y < static_cast<std::size_t>(info_.height_px); ++y) {
      std::memset(pixels_[slot].data() + y * static_cast<std::size_t>(info_.stride_bytes) + half, value + 100, half);
    }
  }

  FakeMachine& machine_;
  FakeSensor& sensor_;
  int id_ = machine_.next_id_++;
  CaptureConfig config_;
  CaptureInfo info_;
  std::vector<bool> busy_;
  std::vector<std::vector<std::byte>> pixels_;
  std::int64_t next_ = 0;
  std::int64_t first_ = 0;
  std::optional<Shot> coming_;
  std::vector<Shot> filled_;
};

LiveCameraConfig live_config(const std::string& left, const std::string& right, int width_px, int height_px) {
  LiveCameraConfig config;
  config.left.device = left;
  config.left.width_px = width_px;
  config.left.height_px = height_px;
  config.left.rate_hz = 1e9 / static_cast<double>(FakeSensor{}.period_ns);
  if (!right.empty()) {
    config.right = config.left;
    config.right->device = right;
  }
  return config;
}

FakeSensor& FakeMachine::add(FakeSensor sensor) {
  sensors_.push_back(std::make_unique<FakeSensor>(std::move(sensor)));
  sensors_.back()->phase_ns += now_ns_;
  return *sensors_.back();
}

Result<std::unique_ptr<CaptureDevice>> FakeMachine::make_device(const CaptureConfig& config) {
  ++attempts;
  for (const auto& sensor : sensors_) {
    const bool is_serial = !sensor->serial.empty() && config.device == sensor->serial;
    if (is_serial || config.device == sensor->path || config.device == sensor->stable_id) {
      return std::make_unique<FakeDevice>(*this, *sensor, config);
    }
  }
  return fail(ErrorCode::kNotFound, config.device + ": no such device");
}

void FakeMachine::wait(std::span<WaitHandle> handles, std::int64_t until_ns) {
  const auto ready_ns = [this](const WaitHandle& handle) {
    const auto device = std::find_if(devices_.begin(), devices_.end(),
                                     [&](const FakeDevice* candidate) { return candidate->wait_fd() == handle.fd; });
    return (*device)->ready_ns();
  };
  std::int64_t earliest_ns = until_ns;
  for (const WaitHandle& handle : handles) {
    earliest_ns = std::min(earliest_ns, ready_ns(handle).value_or(until_ns));
  }
  now_ns_ = std::max(now_ns_, earliest_ns);
  for (WaitHandle& handle : handles) {
    const std::optional<std::int64_t> time_ns = ready_ns(handle);
    handle.ready = time_ns && *time_ns <= now_ns_;
  }
}

}  // namespace kinetrace::hal::test

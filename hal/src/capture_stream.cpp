#include "capture_stream.hpp"

#include <chrono>
#include <utility>

#include "messages.hpp"

namespace kinetrace::hal {
namespace {

// Arrival says how much time has passed up to what a busy machine may delay it by.
constexpr std::int64_t kArrivalTolerance_ns = 1'000'000'000;
constexpr int kMaxRestarts = 3;

}  // namespace

std::size_t CaptureStream::required_bytes(const CaptureConfig& config) {
  return LuminanceReader::required_bytes(config);
}

Result<CaptureStream> CaptureStream::create(std::string eye, const CaptureConfig& config, Arena& arena,
                                            CaptureEnvironment& environment) {
  auto reader = LuminanceReader::create(config, arena);
  if (!reader) {
    return tl::unexpected(reader.error());
  }
  return CaptureStream(std::move(eye), config, std::move(*reader), environment);
}

CaptureStream::CaptureStream(std::string eye, CaptureConfig config, LuminanceReader reader,
                             CaptureEnvironment& environment)
    : eye_(std::move(eye)),
      config_(std::move(config)),
      reader_(std::move(reader)),
      environment_(&environment),
      name_(config_.device),
      timeline_(kArrivalTolerance_ns, true) {}

std::string CaptureStream::described() const {
  return concat(eye_, " (", name_, ")");
}

Status CaptureStream::open() {
  CaptureConfig wanted = config_;
  if (!stable_id_.empty()) {
    wanted.device = stable_id_;
  }
  auto device = environment_->make_device(wanted);
  if (!device) {
    return tl::unexpected(device.error());
  }
  if (Status opened = (*device)->open(); !opened) {
    return opened;
  }
  const CaptureInfo& info = (*device)->info();
  if (info.width_px != config_.width_px || info.height_px != config_.height_px || info.format != config_.format) {
    return fail(ErrorCode::kUnsupported, concat(described(), ": ", size_text(config_.width_px, config_.height_px), " ",
                                                to_string(config_.format), " was asked for, the device set ",
                                                size_text(info.width_px, info.height_px), " ", to_string(info.format),
                                                "; choose a mode that `kinetrace doctor` lists"));
  }
  device_ = std::move(*device);
  name_ = info.name;
  stable_id_ = info.stable_id;
  return {};
}

Status CaptureStream::start() {
  sequence_ = -1;
  ++generation_;
  heard_ns_ = environment_->now_ns();
  return device_->start();
}

Status CaptureStream::stop() {
  return device_->stop();
}

void CaptureStream::close() noexcept {
  if (device_) {
    device_->close();
    device_.reset();
  }
}

bool CaptureStream::is_sound(const CapturedImage& image) const noexcept {
  return !image.damaged && image.slot >= 0 && static_cast<std::size_t>(image.slot) < kMaxSlots;
}

std::int64_t CaptureStream::exposure_ns() const noexcept {
  constexpr double kNanosecondsPerUs = 1e3;
  const auto known_us = device_ ? device_->info().exposure_us : config_.exposure_us;
  return static_cast<std::int64_t>(known_us.value_or(0.0) * kNanosecondsPerUs);
}

std::int64_t CaptureStream::mid_exposure_ns(const CapturedImage& image) const noexcept {
  const bool is_start = device_->info().timestamp_kind == TimestampKind::kStartOfExposure;
  return image.timestamp_ns + (is_start ? exposure_ns() / 2 : -exposure_ns() / 2);
}

// A fatal error of the stream is often mended by starting it again; one that keeps coming back is a loss.
Status CaptureStream::restart(const Error& cause) {
  if (++restarts_in_a_row_ > kMaxRestarts) {
    return fail(ErrorCode::kDisconnected, concat(described(), ": keeps failing: ", cause.message));
  }
  Status restarted = device_->stop();
  if (restarted) {
    restarted = start();
  }
  if (!restarted) {
    return fail(ErrorCode::kDisconnected, concat(described(), ": ", restarted.error().message));
  }
  return {};
}

Result<std::optional<SyncFrame>> CaptureStream::take(CameraCounters& counters) {
  const Result<CapturedImage> image = device_->next(std::chrono::milliseconds(0));
  if (!image && image.error().code == ErrorCode::kTimeout) {
    return std::nullopt;
  }
  if (!image && image.error().code == ErrorCode::kIo) {
    if (const Status mended = restart(image.error()); !mended) {
      return tl::unexpected(mended.error());
    }
    return std::nullopt;
  }
  if (!image) {
    return fail(ErrorCode::kDisconnected, concat(described(), ": ", image.error().message));
  }
  const std::int64_t now_ns = environment_->now_ns();
  heard_ns_ = now_ns;
  restarts_in_a_row_ = 0;
  if (device_->info().sequence_counts_losses && sequence_ >= 0 && image->sequence > sequence_ + 1) {
    counters.gaps += static_cast<std::uint64_t>(image->sequence - sequence_ - 1);
  }
  // Whatever number it comes under.
  const bool is_repeated = sequence_ >= 0 && image->timestamp_ns == stamp_ns_;
  sequence_ = image->sequence;
  stamp_ns_ = image->timestamp_ns;
  if (!is_sound(*image) || is_repeated) {
    ++(is_repeated ? counters.skipped_repeated : counters.skipped_unreadable);
    device_->release(image->slot);
    return std::nullopt;
  }
  const TimelineGuard::Step time = timeline_.correct(mid_exposure_ns(*image), now_ns - taken_ns_);
  taken_ns_ = now_ns;
  counters.clock_jumps += time.jumped ? 1 : 0;
  images_[static_cast<std::size_t>(image->slot)] = *image;
  return SyncFrame{image->slot, image->sequence, time.time_ns};
}

Result<GrayView> CaptureStream::luminance(int slot) {
  return reader_.read(images_[static_cast<std::size_t>(slot)], device_->info());
}

void CaptureStream::release(int slot) noexcept {
  if (device_) {
    device_->release(slot);
  }
}

}  // namespace kinetrace::hal

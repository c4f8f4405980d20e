#include "capture_stream.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
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
  // Every name but a path finds the device wherever it is plugged in.
  if (!identity_.stable_id.empty() && config_.device.starts_with('/')) {
    wanted.device = identity_.stable_id;
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
  if (!identity_.stable_id.empty() && !is_the_same(info)) {
    return fail(ErrorCode::kDisconnected,
                concat(described(), ": another device answers: ", info.name, "; plug the first one in again"));
  }
  device_ = std::move(*device);
  name_ = info.name;
  identity_ = {info.name, info.stable_id, info.serial};
  note_exposure({});
  restarts_in_a_row_ = 0;
  return {};
}

// A device named by its serial number may come back elsewhere. Where no more than a path is known, what answers there
// must at least be called as before.
bool CaptureStream::is_the_same(const CaptureInfo& info) const {
  const bool may_move = !info.serial.empty() && config_.device == info.serial;
  const bool is_known_by_path = identity_.stable_id.starts_with('/');
  return info.serial == identity_.serial && (may_move || info.stable_id == identity_.stable_id) &&
         (!is_known_by_path || info.name == identity_.name);
}

Status CaptureStream::start() {
  sequence_ = -1;
  rate_.reset();
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

// That of the image where the device tells it, else the one that was set. None is longer than a period, whatever a
// driver says.
void CaptureStream::note_exposure(const CapturedImage& image) noexcept {
  constexpr double kNanosecondsPerUs = 1e3;
  constexpr double kNanosecondsPerSecond = 1e9;
  const auto set_ns = static_cast<std::int64_t>(device_->info().exposure_us.value_or(0.0) * kNanosecondsPerUs);
  const auto period_ns = static_cast<std::int64_t>(kNanosecondsPerSecond / config_.rate_hz);
  exposure_ns_ = std::clamp<std::int64_t>(image.exposure_ns.value_or(set_ns), 0, std::max(set_ns, period_ns));
}

std::int64_t CaptureStream::mid_exposure_ns(const CapturedImage& image) const noexcept {
  const bool is_start = device_->info().timestamp_kind == TimestampKind::kStartOfExposure;
  return image.timestamp_ns + (is_start ? exposure_ns_ / 2 : -exposure_ns_ / 2);
}

// Everything that counts in periods relies on the rate; a device that does not tell it is measured.
Status CaptureStream::check_rate(const CapturedImage& image) {
  constexpr double kTolerance = 0.1;
  if (device_->info().rate_hz > 0.0 || config_.trigger == TriggerMode::kExternal) {
    return {};
  }
  const std::optional<double> rate_hz = rate_.add(image.sequence, image.timestamp_ns);
  if (!rate_hz || std::abs(*rate_hz - config_.rate_hz) <= kTolerance * config_.rate_hz) {
    return {};
  }
  return fail(ErrorCode::kUnsupported,
              concat(described(), ": asked for ", number(config_.rate_hz), " Hz, the device delivers ",
                     number(*rate_hz), " Hz; set image.rate_hz to that, shorten the exposure or add light"));
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
  if (const Status as_asked = check_rate(*image); !as_asked) {
    device_->release(image->slot);
    return tl::unexpected(as_asked.error());
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
  note_exposure(*image);
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

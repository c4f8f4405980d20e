#include "capture/capture_stream.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "util/messages.hpp"

namespace kinetrace::hal {
namespace {

// Upper bound of the time from the exposure to a filled buffer.
constexpr std::int64_t kArrivalTolerance_ns = 1'000'000'000;
constexpr int kMaxRestarts = 3;

std::int64_t period_ns(const CaptureConfig& config) {
  return std::llround(1e9 / config.rate_hz);
}

}  // namespace

std::size_t CaptureStream::required_bytes(const CaptureConfig& config) {
  return LuminanceReader::required_bytes(config);
}

Result<CaptureStream> CaptureStream::create(std::string view, const CaptureConfig& config, Arena& arena,
                                            CaptureEnvironment& environment) {
  auto reader = LuminanceReader::create(config, arena);
  if (!reader) {
    return Unexpected(reader.error());
  }
  return CaptureStream(std::move(view), config, std::move(*reader), environment);
}

CaptureStream::CaptureStream(std::string view, CaptureConfig config, LuminanceReader reader,
                             CaptureEnvironment& environment)
    : view_(std::move(view)),
      config_(std::move(config)),
      reader_(std::move(reader)),
      environment_(&environment),
      name_(config_.device),
      timeline_(kArrivalTolerance_ns, true),
      numbering_(period_ns(config_)) {}

std::string CaptureStream::described() const {
  return concat(view_, " (", name_, ")");
}

Status CaptureStream::open() {
  CaptureConfig wanted = config_;
  // A path may change when the device is plugged in again; all other names stay valid.
  if (!identity_.stable_id.empty() && config_.device.starts_with('/')) {
    wanted.device = identity_.stable_id;
  }
  auto device = environment_->make_device(wanted);
  if (!device) {
    return Unexpected(device.error());
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

// A device configured by its serial number may return on another port. A device known by its path alone must at least
// have the same name as before.
bool CaptureStream::is_the_same(const CaptureInfo& info) const {
  const bool may_move = !info.serial.empty() && config_.device == info.serial;
  const bool is_known_by_path = identity_.stable_id.starts_with('/');
  return info.serial == identity_.serial && (may_move || info.stable_id == identity_.stable_id) &&
         (!is_known_by_path || info.name == identity_.name);
}

Status CaptureStream::start() {
  numbering_.restart();
  stamp_ns_.reset();
  rate_.reset();
  ++generation_;
  last_image_ns_ = environment_->now_ns();
  note_empty();
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

bool CaptureStream::is_usable(const CapturedImage& image) const noexcept {
  return !image.damaged && image.slot >= 0 && static_cast<std::size_t>(image.slot) < kMaxSlots;
}

// The exposure that the device reports for the image, else the one that was set; limited to a period, since drivers may
// report nonsense.
void CaptureStream::note_exposure(const CapturedImage& image) noexcept {
  constexpr double kNanosecondsPerUs = 1e3;
  const auto set_ns = static_cast<std::int64_t>(device_->info().exposure_us.value_or(0.0) * kNanosecondsPerUs);
  exposure_ns_ = std::clamp<std::int64_t>(image.exposure_ns.value_or(set_ns), 0, std::max(set_ns, period_ns(config_)));
}

std::int64_t CaptureStream::mid_exposure_ns(const CapturedImage& image) const noexcept {
  const bool is_start = device_->info().timestamp_kind == TimestampKind::kStartOfExposure;
  return image.timestamp_ns + (is_start ? exposure_ns_ / 2 : -exposure_ns_ / 2);
}

// Numbering and pairing count in periods and rely on the rate: it is measured if the device does not report it.
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

// A restart often repairs a fatal error of the stream; a repeated error is a loss.
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

// Handles a call of next() without an image.
Result<std::optional<SyncFrame>> CaptureStream::handle_no_image(const Error& error) {
  if (error.code == ErrorCode::kTimeout) {
    note_empty();
    return std::nullopt;
  }
  if (error.code != ErrorCode::kIo) {
    return fail(ErrorCode::kDisconnected, concat(described(), ": ", error.message));
  }
  if (const Status mended = restart(error); !mended) {
    return Unexpected(mended.error());
  }
  return std::nullopt;
}

// An image arrives between the last time that the device had none and the time that it is taken: it may have waited in
// the driver.
std::int64_t CaptureStream::plausible_time_ns(const CapturedImage& image, CameraCounters& counters) noexcept {
  const Arrival arrival{empty_ns_, last_image_ns_};
  const TimelineGuard::Evidence evidence{.expected_ns = arrival.latest_ns - arrival_.latest_ns,
                                         .shortest_ns = arrival.earliest_ns - arrival_.latest_ns,
                                         .longest_ns = arrival.latest_ns - arrival_.earliest_ns};
  const TimelineGuard::Step time = timeline_.correct(mid_exposure_ns(image), evidence);
  arrival_ = arrival;
  counters.clock_jumps += time.jumped ? 1 : 0;
  return time.time_ns;
}

// Triggered images are not numbered by time: they have no period.
std::int64_t CaptureStream::number_of(const CapturedImage& image, std::optional<std::int64_t> time_ns) noexcept {
  const bool is_counted = device_->info().sequence_counts_losses;
  const bool is_timed = config_.trigger == TriggerMode::kFreeRunning;
  return numbering_.next(is_counted ? std::optional(image.sequence) : std::nullopt, is_timed ? time_ns : std::nullopt);
}

Result<std::optional<SyncFrame>> CaptureStream::take(CameraCounters& counters) {
  const Result<CapturedImage> image = device_->next(std::chrono::milliseconds(0));
  if (!image) {
    return handle_no_image(image.error());
  }
  last_image_ns_ = environment_->now_ns();
  restarts_in_a_row_ = 0;
  if (const Status as_asked = check_rate(*image); !as_asked) {
    device_->release(image->slot);
    return Unexpected(as_asked.error());
  }
  // Even under a new sequence number.
  const bool is_repeated = stamp_ns_ == image->timestamp_ns;
  stamp_ns_ = image->timestamp_ns;
  if (!is_usable(*image) || is_repeated) {
    number_of(*image, std::nullopt);
    ++(is_repeated ? counters.skipped_repeated : counters.skipped_unreadable);
    device_->release(image->slot);
    return std::nullopt;
  }
  note_exposure(*image);
  const std::int64_t time_ns = plausible_time_ns(*image, counters);
  images_[static_cast<std::size_t>(image->slot)] = *image;
  return SyncFrame{image->slot, number_of(*image, time_ns), time_ns};
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

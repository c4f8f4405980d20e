#include "kinetrace/hal/live_stereo_camera.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "capture/camera_state_machine.hpp"
#include "capture/capture_stream.hpp"
#include "capture/stereo_pairer.hpp"
#include "util/messages.hpp"

namespace kinetrace::hal {
namespace {

constexpr double kNanosecondsPerMs = 1e6;

std::int64_t from_ms(double milliseconds) {
  return std::llround(milliseconds * kNanosecondsPerMs);
}

std::string seconds_text(std::int64_t nanoseconds) {
  constexpr double kTenthsPerNanosecond = 1e-8;
  return number(std::round(static_cast<double>(nanoseconds) * kTenthsPerNanosecond) / 10.0);
}

std::int64_t period_ns(const LiveCameraConfig& config) {
  return std::llround(1e9 / config.left.rate_hz);
}

SyncConfig sync_config(const LiveCameraConfig& config) {
  const std::int64_t period = period_ns(config);
  return {.period_ns = period, .tolerance_ns = std::min(from_ms(config.pair_tolerance_ms), period / 2)};
}

CameraTimeouts timeouts_of(const LiveCameraConfig& config) {
  const bool is_triggered = config.left.trigger == TriggerMode::kExternal ||
                            (config.right && config.right->trigger == TriggerMode::kExternal);
  return {.stall_ns = from_ms(config.stall_timeout_ms),
          .lost_ns = is_triggered ? std::nullopt : std::optional(from_ms(config.lost_timeout_ms)),
          .reopen_first_ns = from_ms(config.reopen_first_ms),
          .reopen_longest_ns = from_ms(config.reopen_longest_ms)};
}

CameraInfo info_of(const LiveCameraConfig& config) {
  const int views_in_image = config.right ? 1 : 2;
  return {.name = config.right ? concat(config.left.device, " + ", config.right->device) : config.left.device,
          .width_px = config.left.width_px / views_in_image,
          .height_px = config.left.height_px,
          .nominal_rate_hz = config.left.rate_hz,
          .frame_count = std::nullopt};
}

}  // namespace

struct LiveStereoCamera::Impl {
  LiveCameraConfig config;
  CaptureEnvironment* environment;
  std::vector<CaptureStream> streams;  ///< Left and right, or the one with both.
  CameraInfo info;
  CameraCounters counters{};
  CameraStateMachine states;
  StereoPairer pairer;
  std::uint64_t unreadable_at_last_frame = 0;
  std::int64_t last_time_ns = 0;
  std::int64_t last_index = -1;

  Impl(const LiveCameraConfig& config_, std::vector<CaptureStream> streams_, CaptureEnvironment& environment_)
      : config(config_),
        environment(&environment_),
        streams(std::move(streams_)),
        info(info_of(config)),
        states(timeouts_of(config)),
        pairer(streams, environment_, sync_config(config), config.left.buffers, counters) {}
  Impl(const Impl&) = delete;  // The pairer refers to streams and counters.
  Impl& operator=(const Impl&) = delete;

  /// `success`: event of a successful `call`.
  [[nodiscard]] Status require(CameraEvent success, const char* call) const;
  void handle(CameraEvent event);

  [[nodiscard]] Status open_streams();
  [[nodiscard]] Status start_streams();
  Status stop_streams();
  void close_streams();

  [[nodiscard]] bool advance_to(std::int64_t time_ns);
  [[nodiscard]] std::optional<StereoFrame> deliver();

  [[nodiscard]] std::int64_t longest_exposure_ns() const;
  [[nodiscard]] Error no_data_error(std::int64_t now_ns) const;
  [[nodiscard]] Error timeout(std::int64_t now_ns);
  [[nodiscard]] Error lose(Error cause);
};

Status LiveStereoCamera::Impl::require(CameraEvent success, const char* call) const {
  if (!states.accepts(success)) {
    return fail(ErrorCode::kIllegalState, concat(info.name, ": ", call, " is not allowed while the camera is ",
                                                 to_string(states.state()), "; see the states of StereoCamera"));
  }
  return {};
}

void LiveStereoCamera::Impl::handle(CameraEvent event) {
  states.handle(event, environment->now_ns());
}

Status LiveStereoCamera::Impl::open_streams() {
  for (CaptureStream& stream : streams) {
    if (Status opened = stream.open(); !opened) {
      close_streams();
      return opened;
    }
  }
  info.name = pairer.side_by_side() ? streams[0].name() : concat(streams[0].name(), " + ", streams[1].name());
  return {};
}

Status LiveStereoCamera::Impl::start_streams() {
  for (CaptureStream& stream : streams) {
    if (Status started = stream.start(); !started) {
      return started;
    }
  }
  pairer.begin();
  unreadable_at_last_frame = counters.skipped_unreadable;
  return {};
}

// Stops all streams, even after an error; returns the first error.
Status LiveStereoCamera::Impl::stop_streams() {
  Status stopped;
  for (CaptureStream& stream : streams) {
    if (Status status = stream.stop(); stopped && !status) {
      stopped = status;
    }
  }
  return stopped;
}

void LiveStereoCamera::Impl::close_streams() {
  pairer.release_all();
  for (CaptureStream& stream : streams) {
    stream.close();
  }
}

// Advances the frame number by whole periods; false if the time does not increase.
bool LiveStereoCamera::Impl::advance_to(std::int64_t time_ns) {
  if (last_index < 0) {
    last_index = 0;
  } else if (time_ns <= last_time_ns) {
    return false;
  } else {
    const std::int64_t period = period_ns(config);
    last_index += std::max<std::int64_t>(1, (time_ns - last_time_ns + period / 2) / period);
  }
  last_time_ns = time_ns;
  return true;
}

// The newest pair as a frame; none without a usable pair.
std::optional<StereoFrame> LiveStereoCamera::Impl::deliver() {
  const std::optional<SyncPair> pair = pairer.take();
  if (!pair) {
    return std::nullopt;
  }
  const std::optional<StereoViews> views = pairer.views(*pair);
  if (!views || !advance_to(pair->left.time_ns)) {
    ++(views ? counters.skipped_repeated : counters.skipped_unreadable);
    pairer.release_taken();
    return std::nullopt;
  }
  ++counters.frames_delivered;
  pairer.count_gaps(*pair);
  unreadable_at_last_frame = counters.skipped_unreadable;
  handle(CameraEvent::kFrame);
  return StereoFrame{last_index, last_time_ns, {}, views->left, views->right};
}

std::int64_t LiveStereoCamera::Impl::longest_exposure_ns() const {
  std::int64_t longest_ns = 0;
  for (const CaptureStream& stream : streams) {
    longest_ns = std::max(longest_ns, stream.exposure_ns());
  }
  return longest_ns;
}

// Names the camera with the oldest last image if that explains the stall, else the reason why images did not become
// frames.
Error LiveStereoCamera::Impl::no_data_error(std::int64_t now_ns) const {
  const auto oldest = std::min_element(streams.begin(), streams.end(), [](const auto& a, const auto& b) {
    return a.last_image_ns() < b.last_image_ns();
  });
  const std::int64_t without_image_ns = now_ns - oldest->last_image_ns();
  const std::int64_t without_frame_ns = now_ns - states.last_frame_ns();
  const std::string for_so_long = concat(" for ", seconds_text(without_frame_ns), " s; ");
  const std::uint64_t unreadable = counters.skipped_unreadable - unreadable_at_last_frame;
  if (2 * without_image_ns >= without_frame_ns) {
    return {ErrorCode::kTimeout, concat(oldest->described(), ": no image for ", seconds_text(without_image_ns),
                                        " s; check cable, power and trigger")};
  }
  if (unreadable > 0) {
    return {ErrorCode::kTimeout,
            concat(info.name, ": ", std::to_string(unreadable), " images came damaged and no good pair", for_so_long,
                   "check the cables, lower rate or size, or use a port of its own for each camera")};
  }
  if (pairer.side_by_side()) {
    return {ErrorCode::kTimeout,
            concat(info.name, ": images come, but none is new", for_so_long, "unplug the camera and plug it in again")};
  }
  return {ErrorCode::kTimeout, concat(info.name, ": both cameras deliver, but nothing fitted together", for_so_long,
                                      "check that both run at ", number(config.left.rate_hz),
                                      " Hz, are triggered together, and pairing.tolerance_ms")};
}

Error LiveStereoCamera::Impl::lose(Error cause) {
  close_streams();
  handle(CameraEvent::kLost);
  ++counters.losses;
  return {ErrorCode::kDisconnected, std::move(cause.message)};
}

// The error of next() without a frame.
Error LiveStereoCamera::Impl::timeout(std::int64_t now_ns) {
  const std::optional<CameraEvent> expired = states.expired(now_ns, longest_exposure_ns());
  if (expired == CameraEvent::kLost) {
    return lose(no_data_error(now_ns));
  }
  if (expired == CameraEvent::kStallTimeout) {
    handle(CameraEvent::kStallTimeout);
    ++counters.stalls;
  }
  return no_data_error(now_ns);
}

std::size_t LiveStereoCamera::required_bytes(const LiveCameraConfig& config) {
  return CaptureStream::required_bytes(config.left) + (config.right ? CaptureStream::required_bytes(*config.right) : 0);
}

Result<LiveStereoCamera> LiveStereoCamera::create(const LiveCameraConfig& config, Arena& arena) {
  return create(config, arena, machine_environment());
}

Result<LiveStereoCamera> LiveStereoCamera::create(const LiveCameraConfig& config, Arena& arena,
                                                  CaptureEnvironment& environment) {
  if (const Status valid = config.validate(); !valid) {
    return Unexpected(valid.error());
  }
  std::vector<CaptureStream> streams;
  auto left = CaptureStream::create(config.right ? "left camera" : "stereo camera", config.left, arena, environment);
  if (!left) {
    return Unexpected(left.error());
  }
  streams.push_back(std::move(*left));
  if (config.right) {
    auto right = CaptureStream::create("right camera", *config.right, arena, environment);
    if (!right) {
      return Unexpected(right.error());
    }
    streams.push_back(std::move(*right));
  }
  return LiveStereoCamera(std::make_unique<Impl>(config, std::move(streams), environment));
}

LiveStereoCamera::LiveStereoCamera(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
LiveStereoCamera::LiveStereoCamera(LiveStereoCamera&&) noexcept = default;
LiveStereoCamera& LiveStereoCamera::operator=(LiveStereoCamera&&) noexcept = default;
LiveStereoCamera::~LiveStereoCamera() {
  if (impl_) {
    impl_->close_streams();
  }
}

Status LiveStereoCamera::open() {
  Impl& self = *impl_;
  Status status = self.require(CameraEvent::kOpened, "open()");
  if (status) {
    status = self.open_streams();
  }
  if (status) {
    self.handle(CameraEvent::kOpened);
  }
  return status;
}

Status LiveStereoCamera::start() {
  Impl& self = *impl_;
  if (Status legal = self.require(CameraEvent::kStarted, "start()"); !legal) {
    return legal;
  }
  self.counters = {};
  self.pairer.reset();
  self.last_index = -1;
  if (Status started = self.start_streams(); !started) {
    static_cast<void>(self.stop_streams());  // The reason of the failed start matters more.
    return started;
  }
  self.handle(CameraEvent::kStarted);
  return {};
}

Result<StereoFrame> LiveStereoCamera::next(std::chrono::milliseconds timeout) {
  Impl& self = *impl_;
  if (const Status legal = self.require(CameraEvent::kFrame, "next()"); !legal) {
    return Unexpected(legal.error());
  }
  self.pairer.release_taken();
  const std::int64_t until_ns = self.environment->now_ns() + std::chrono::nanoseconds(timeout).count();
  for (;;) {
    if (const Status gathered = self.pairer.gather(); !gathered) {
      return Unexpected(self.lose(gathered.error()));
    }
    if (const std::optional<StereoFrame> frame = self.deliver()) {
      return *frame;
    }
    const std::int64_t now_ns = self.environment->now_ns();
    const std::int64_t deadline_ns = std::min(until_ns, self.states.loss_due_ns(self.longest_exposure_ns()));
    if (now_ns >= deadline_ns) {
      return Unexpected(self.timeout(now_ns));
    }
    self.pairer.wait(now_ns, deadline_ns);
  }
}

Status LiveStereoCamera::stop() {
  Impl& self = *impl_;
  if (Status legal = self.require(CameraEvent::kStopped, "stop()"); !legal) {
    return legal;
  }
  self.pairer.release_all();
  self.handle(CameraEvent::kStopped);
  return self.stop_streams();
}

Status LiveStereoCamera::recover() {
  Impl& self = *impl_;
  if (Status legal = self.require(CameraEvent::kReopened, "recover()"); !legal) {
    return legal;
  }
  if (!self.states.is_reopen_due(self.environment->now_ns())) {
    return fail(ErrorCode::kDisconnected, self.info.name + ": still gone; the next attempt is not yet due");
  }
  Status status = self.open_streams();
  if (status) {
    status = self.start_streams();
  }
  if (!status) {
    self.close_streams();
    self.handle(CameraEvent::kReopenFailed);
    return fail(ErrorCode::kDisconnected, status.error().message);
  }
  self.handle(CameraEvent::kReopened);
  ++self.counters.recoveries;
  return {};
}

void LiveStereoCamera::close() noexcept {
  impl_->close_streams();
  impl_->handle(CameraEvent::kClosed);
}

CameraState LiveStereoCamera::state() const noexcept {
  return impl_->states.state();
}
const CameraInfo& LiveStereoCamera::info() const noexcept {
  return impl_->info;
}
const CameraCounters& LiveStereoCamera::counters() const noexcept {
  return impl_->counters;
}

bool LiveStereoCamera::move_pairing(int frames) noexcept {
  return impl_->pairer.move(frames);
}

PairingStatus LiveStereoCamera::pairing() const noexcept {
  const FrameSynchronizer& synchronizer = impl_->pairer.synchronizer();
  return {.offset_ms = static_cast<double>(synchronizer.offset_ns()) / kNanosecondsPerMs,
          .drift_ppm = synchronizer.drift() * 1e6,
          .relearned = synchronizer.counters().relocks};
}

}  // namespace kinetrace::hal

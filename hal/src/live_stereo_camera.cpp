#include "kinetrace/hal/live_stereo_camera.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "capture_stream.hpp"
#include "messages.hpp"
#include "missed_frames.hpp"

namespace kinetrace::hal {
namespace {

constexpr double kNanosecondsPerMs = 1e6;
// How long a device is left alone that reports itself ready and has nothing.
constexpr std::int64_t kBreath_ns = 1'000'000;

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

CameraInfo info_of(const LiveCameraConfig& config, std::string name) {
  const int eyes_in_image = config.right ? 1 : 2;
  return {.name = std::move(name),
          .width_px = config.left.width_px / eyes_in_image,
          .height_px = config.left.height_px,
          .nominal_rate_hz = config.left.rate_hz,
          .frame_count = std::nullopt};
}

}  // namespace

struct LiveStereoCamera::Impl {
  LiveCameraConfig config;
  CaptureEnvironment* environment;
  std::vector<CaptureStream> streams;  ///< Left and right, or the one with both.
  FrameSynchronizer synchronizer;
  MissedFrames missed;
  CameraInfo info;
  CameraState state = CameraState::kClosed;
  CameraCounters counters{};
  std::array<int, 2> generations{};
  std::optional<SyncPair> held{};       ///< Its views are with the caller.
  std::optional<SyncPair> candidate{};  ///< The newest pair so far.
  std::int64_t delivered_ns = 0;        ///< When the last frame was handed out, or the streams started.
  std::uint64_t unreadable_until_then = 0;
  std::int64_t last_time_ns = 0;
  std::int64_t last_index = -1;
  std::int64_t pause_ns = 0;  ///< Between attempts to reopen.
  std::int64_t next_attempt_ns = 0;

  Impl(const LiveCameraConfig& config_, std::vector<CaptureStream> streams_, CaptureEnvironment& environment_)
      : config(config_),
        environment(&environment_),
        streams(std::move(streams_)),
        synchronizer(sync_config(config)),
        info(info_of(config,
                     config.right ? concat(config.left.device, " + ", config.right->device) : config.left.device)) {}

  [[nodiscard]] bool side_by_side() const { return streams.size() == 1; }
  [[nodiscard]] Status require(bool allowed, const char* call) const;
  [[nodiscard]] Status open_streams();
  [[nodiscard]] Status start_streams();
  Status stop_streams();
  void close_streams();

  void release(const SyncPair& pair);
  void release_all();
  [[nodiscard]] Result<bool> gather();
  [[nodiscard]] Result<bool> take_image(std::size_t eye);
  /// Returns how many streams have been started again since the last call.
  std::uint64_t look_at_restarts();
  void offer(const SyncPair& pair);
  void note_delivery();
  void collect_drops();
  [[nodiscard]] std::optional<StereoFrame> deliver();
  [[nodiscard]] bool advance_to(std::int64_t time_ns);

  std::array<WaitHandle, 2> wait_until(std::int64_t time_ns);
  [[nodiscard]] std::int64_t patience_ns() const;
  [[nodiscard]] std::int64_t limit_ns() const;
  [[nodiscard]] bool never_lost_by_silence() const;
  [[nodiscard]] Error silence(std::int64_t now_ns) const;
  [[nodiscard]] Error timeout(std::int64_t now_ns);
  [[nodiscard]] Error lose(Error cause);
};

Status LiveStereoCamera::Impl::require(bool allowed, const char* call) const {
  if (!allowed) {
    return fail(ErrorCode::kIllegalState, concat(info.name, ": ", call, " is not allowed while the camera is ",
                                                 to_string(state), "; see the states of StereoCamera"));
  }
  return {};
}

Status LiveStereoCamera::Impl::open_streams() {
  for (CaptureStream& stream : streams) {
    if (Status opened = stream.open(); !opened) {
      close_streams();
      return opened;
    }
  }
  info.name = side_by_side() ? streams[0].name() : concat(streams[0].name(), " + ", streams[1].name());
  return {};
}

Status LiveStereoCamera::Impl::start_streams() {
  for (CaptureStream& stream : streams) {
    if (Status started = stream.start(); !started) {
      return started;
    }
  }
  static_cast<void>(look_at_restarts());  // These are the first starts.
  missed.restart();
  note_delivery();
  return {};
}

// All of them, whatever happens to one; the first error.
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
  release_all();
  for (CaptureStream& stream : streams) {
    stream.close();
  }
}

void LiveStereoCamera::Impl::release(const SyncPair& pair) {
  streams[0].release(pair.left.slot);
  if (!side_by_side()) {
    streams[1].release(pair.right.slot);
  }
}

void LiveStereoCamera::Impl::release_all() {
  for (std::optional<SyncPair>* pair : {&held, &candidate}) {
    if (*pair) {
      release(**pair);
      pair->reset();
    }
  }
}

// A stream that was started again has taken all its buffers back: nothing of it may be used or released any more.
std::uint64_t LiveStereoCamera::Impl::look_at_restarts() {
  std::uint64_t restarts = 0;
  for (std::size_t eye = 0; eye < streams.size(); ++eye) {
    if (generations[eye] == streams[eye].generation()) {
      continue;
    }
    generations[eye] = streams[eye].generation();
    ++restarts;
    synchronizer.forget(eye == 0 ? Eye::kLeft : Eye::kRight);
    counters.skipped_missing_side += candidate ? 1 : 0;
    if (candidate && !side_by_side()) {
      const bool left_is_gone = eye == 0;
      streams[left_is_gone ? 1 : 0].release(left_is_gone ? candidate->right.slot : candidate->left.slot);
    }
    candidate.reset();
  }
  return restarts;
}

void LiveStereoCamera::Impl::offer(const SyncPair& pair) {
  if (candidate) {
    release(*candidate);
    ++counters.skipped_outdated;
  }
  candidate = pair;
}

// Only what reaches the caller ends a silence: images that cannot be read or used are as good as none.
void LiveStereoCamera::Impl::note_delivery() {
  delivered_ns = environment->now_ns();
  unreadable_until_then = counters.skipped_unreadable;
}

void LiveStereoCamera::Impl::collect_drops() {
  while (const std::optional<SyncDrop> drop = synchronizer.next_drop()) {
    const bool is_stale = drop->reason == SyncDrop::Reason::kStale;
    ++(is_stale ? counters.skipped_repeated : counters.skipped_missing_side);
    streams[static_cast<std::size_t>(drop->eye)].release(drop->frame.slot);
  }
  counters.pairing_slips = synchronizer.counters().slips;
}

// Whether the device had a usable image.
Result<bool> LiveStereoCamera::Impl::take_image(std::size_t eye) {
  const Result<std::optional<SyncFrame>> frame = streams[eye].take(counters);
  counters.stream_restarts += look_at_restarts();
  missed.see(eye == 0 ? Eye::kLeft : Eye::kRight, streams[eye].image_number());
  if (!frame) {
    return Unexpected(frame.error());
  }
  if (!*frame) {
    return false;
  }
  if (side_by_side()) {
    offer({**frame, **frame});
    return true;
  }
  synchronizer.add(eye == 0 ? Eye::kLeft : Eye::kRight, **frame);
  while (const std::optional<SyncPair> pair = synchronizer.next_pair()) {
    offer(*pair);
  }
  collect_drops();
  return true;
}

std::array<WaitHandle, 2> LiveStereoCamera::Impl::wait_until(std::int64_t time_ns) {
  std::array<WaitHandle, 2> handles{};
  for (std::size_t eye = 0; eye < streams.size(); ++eye) {
    handles[eye].fd = streams[eye].wait_fd();
  }
  environment->wait(std::span(handles).first(streams.size()), time_ns);
  return handles;
}

// Everything the devices have, alternating between them; at most so much as they can have queued. True if one of them
// reported itself ready and had nothing: to wait for it then would be no waiting.
Result<bool> LiveStereoCamera::Impl::gather() {
  bool any_ready = true;
  bool any_empty = false;
  for (int round = 0; any_ready && round < config.left.buffers; ++round) {
    const std::array<WaitHandle, 2> handles = wait_until(0);
    any_ready = false;
    for (std::size_t eye = 0; eye < streams.size(); ++eye) {
      if (!handles[eye].ready) {
        streams[eye].note_empty();
        continue;
      }
      any_ready = true;
      const Result<bool> taken = take_image(eye);
      if (!taken) {
        return Unexpected(taken.error());
      }
      any_empty = any_empty || !*taken;
    }
  }
  return any_empty;
}

// Later than everything before, in whole periods; false if it is not later.
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

std::optional<StereoFrame> LiveStereoCamera::Impl::deliver() {
  held = std::exchange(candidate, std::nullopt);
  Result<GrayView> left = streams[0].luminance(held->left.slot);
  Result<GrayView> right = side_by_side() ? left : streams[1].luminance(held->right.slot);
  const bool is_readable = left && right;
  if (!is_readable || !advance_to(held->left.time_ns)) {
    ++(is_readable ? counters.skipped_repeated : counters.skipped_unreadable);
    release(*held);
    held.reset();
    return std::nullopt;
  }
  if (side_by_side()) {
    left->width /= 2;
    right->width = left->width;
    right->data += left->width;
  }
  ++counters.frames_delivered;
  counters.gaps += missed.deliver(held->left.sequence, held->right.sequence);
  note_delivery();
  state = CameraState::kStreaming;
  return StereoFrame{last_index, last_time_ns, {}, *left, *right};
}

std::int64_t LiveStereoCamera::Impl::patience_ns() const {
  std::int64_t longest_ns = 0;
  for (const CaptureStream& stream : streams) {
    longest_ns = std::max(longest_ns, stream.exposure_ns());
  }
  return from_ms(config.stall_timeout_ms) + longest_ns;
}

// The longest silence that is borne.
std::int64_t LiveStereoCamera::Impl::limit_ns() const {
  return never_lost_by_silence() ? std::numeric_limits<std::int64_t>::max() / 2
                                 : patience_ns() + from_ms(config.lost_timeout_ms);
}

bool LiveStereoCamera::Impl::never_lost_by_silence() const {
  return config.left.trigger == TriggerMode::kExternal ||
         (config.right && config.right->trigger == TriggerMode::kExternal);
}

// Names the eye that has been silent for longest, if one has been; else why images did not become frames.
Error LiveStereoCamera::Impl::silence(std::int64_t now_ns) const {
  const auto quietest = std::min_element(streams.begin(), streams.end(),
                                         [](const auto& a, const auto& b) { return a.heard_ns() < b.heard_ns(); });
  const std::int64_t silent_ns = now_ns - quietest->heard_ns();
  const std::int64_t without_frame_ns = now_ns - delivered_ns;
  const std::string for_so_long = concat(" for ", seconds_text(without_frame_ns), " s; ");
  const std::uint64_t unreadable = counters.skipped_unreadable - unreadable_until_then;
  if (2 * silent_ns >= without_frame_ns) {
    return {ErrorCode::kTimeout, concat(quietest->described(), ": no image for ", seconds_text(silent_ns),
                                        " s; check cable, power and trigger")};
  }
  if (unreadable > 0) {
    return {ErrorCode::kTimeout,
            concat(info.name, ": ", std::to_string(unreadable), " images came damaged and no good pair", for_so_long,
                   "check the cables, lower rate or size, or use a port of its own for each camera")};
  }
  if (side_by_side()) {
    return {ErrorCode::kTimeout,
            concat(info.name, ": images come, but none is new", for_so_long, "unplug the camera and plug it in again")};
  }
  return {ErrorCode::kTimeout,
          concat(info.name, ": both eyes deliver, but nothing fitted together", for_so_long, "check that both run at ",
                 number(config.left.rate_hz), " Hz, are triggered together, and pairing.tolerance_ms")};
}

Error LiveStereoCamera::Impl::lose(Error cause) {
  close_streams();
  state = CameraState::kLost;
  ++counters.losses;
  pause_ns = from_ms(config.reopen_first_ms);
  next_attempt_ns = environment->now_ns() + pause_ns;
  return {ErrorCode::kDisconnected, std::move(cause.message)};
}

Error LiveStereoCamera::Impl::timeout(std::int64_t now_ns) {
  const std::int64_t silent_ns = now_ns - delivered_ns;
  if (silent_ns > limit_ns()) {
    return lose(silence(now_ns));
  }
  if (silent_ns > patience_ns() && state == CameraState::kStreaming) {
    state = CameraState::kStalled;
    ++counters.stalls;
  }
  return silence(now_ns);
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
  auto left = CaptureStream::create(config.right ? "left eye" : "stereo camera", config.left, arena, environment);
  if (!left) {
    return Unexpected(left.error());
  }
  streams.push_back(std::move(*left));
  if (config.right) {
    auto right = CaptureStream::create("right eye", *config.right, arena, environment);
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
  Status status = self.require(self.state == CameraState::kClosed, "open()");
  if (status) {
    status = self.open_streams();
  }
  if (status) {
    self.state = CameraState::kConfigured;
  }
  return status;
}

Status LiveStereoCamera::start() {
  Impl& self = *impl_;
  if (Status legal = self.require(self.state == CameraState::kConfigured, "start()"); !legal) {
    return legal;
  }
  self.counters = {};
  self.synchronizer = FrameSynchronizer(sync_config(self.config));
  self.last_index = -1;
  if (Status started = self.start_streams(); !started) {
    static_cast<void>(self.stop_streams());  // Why it did not start says more.
    return started;
  }
  self.state = CameraState::kStreaming;
  return {};
}

Result<StereoFrame> LiveStereoCamera::next(std::chrono::milliseconds timeout) {
  Impl& self = *impl_;
  const bool allowed = self.state == CameraState::kStreaming || self.state == CameraState::kStalled ||
                       self.state == CameraState::kRecovering;
  if (const Status legal = self.require(allowed, "next()"); !legal) {
    return Unexpected(legal.error());
  }
  if (self.held) {
    self.release(*self.held);
    self.held.reset();
  }
  const std::int64_t until_ns = self.environment->now_ns() + std::chrono::nanoseconds(timeout).count();
  for (;;) {
    const Result<bool> was_empty = self.gather();
    if (!was_empty) {
      return Unexpected(self.lose(was_empty.error()));
    }
    if (self.candidate) {
      if (const std::optional<StereoFrame> frame = self.deliver()) {
        return *frame;
      }
    }
    const std::int64_t now_ns = self.environment->now_ns();
    if (now_ns >= until_ns || now_ns - self.delivered_ns > self.limit_ns()) {
      return Unexpected(self.timeout(now_ns));
    }
    if (*was_empty) {
      self.environment->wait({}, now_ns + kBreath_ns);
    } else {
      self.wait_until(std::min(until_ns, self.delivered_ns + self.limit_ns() + 1));
    }
  }
}

Status LiveStereoCamera::stop() {
  Impl& self = *impl_;
  const bool allowed = self.state == CameraState::kStreaming || self.state == CameraState::kStalled ||
                       self.state == CameraState::kRecovering;
  if (Status legal = self.require(allowed, "stop()"); !legal) {
    return legal;
  }
  self.release_all();
  self.state = CameraState::kConfigured;
  return self.stop_streams();
}

Status LiveStereoCamera::recover() {
  Impl& self = *impl_;
  if (Status legal = self.require(self.state == CameraState::kLost, "recover()"); !legal) {
    return legal;
  }
  const std::int64_t now_ns = self.environment->now_ns();
  if (now_ns < self.next_attempt_ns) {
    return fail(ErrorCode::kDisconnected, self.info.name + ": still gone; the next attempt is not yet due");
  }
  Status status = self.open_streams();
  if (status) {
    status = self.start_streams();
  }
  if (!status) {
    self.close_streams();
    self.pause_ns = std::min(2 * self.pause_ns, from_ms(self.config.reopen_longest_ms));
    self.next_attempt_ns = self.environment->now_ns() + self.pause_ns;
    return fail(ErrorCode::kDisconnected, status.error().message);
  }
  ++self.counters.recoveries;
  self.state = CameraState::kRecovering;
  return {};
}

void LiveStereoCamera::close() noexcept {
  impl_->close_streams();
  impl_->state = CameraState::kClosed;
}

CameraState LiveStereoCamera::state() const noexcept {
  return impl_->state;
}
const CameraInfo& LiveStereoCamera::info() const noexcept {
  return impl_->info;
}
const CameraCounters& LiveStereoCamera::counters() const noexcept {
  return impl_->counters;
}

bool LiveStereoCamera::move_pairing(int frames) noexcept {
  if (impl_->side_by_side()) {
    return false;
  }
  impl_->synchronizer.move(frames);
  ++impl_->counters.pairing_moves;
  return true;
}

PairingStatus LiveStereoCamera::pairing() const noexcept {
  const FrameSynchronizer& pairing = impl_->synchronizer;
  return {.offset_ms = static_cast<double>(pairing.offset_ns()) / kNanosecondsPerMs,
          .drift_ppm = pairing.drift() * 1e6,
          .relearned = pairing.counters().relocks};
}

}  // namespace kinetrace::hal

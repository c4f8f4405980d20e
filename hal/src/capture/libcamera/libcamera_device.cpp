#include <algorithm>
#include <cerrno>
#include <cmath>
#include <ctime>
#include <libcamera/libcamera.h>
#include <linux/dma-buf.h>
#include <optional>
#include <span>
#include <string>
#include <sys/ioctl.h>
#include <system_error>
#include <utility>
#include <vector>

#include "capture/completed_queue.hpp"
#include "capture/frame_wait.hpp"
#include "capture/image_layout.hpp"
#include "capture/libcamera/libcamera_controls.hpp"
#include "capture/libcamera/libcamera_manager.hpp"
#include "capture/mapped_bytes.hpp"
#include "capture/settings_check.hpp"
#include "kinetrace/core/allocation_counter.hpp"
#include "synchronization/sequence_unwrapper.hpp"
#include "util/messages.hpp"
#include "util/monotonic_time.hpp"

namespace kinetrace::hal {
namespace {

// The camera's pipeline handler chooses the number, whatever was requested. Pairing holds up to three buffers; one more
// has to be filled meanwhile.
constexpr std::size_t kMinBuffers = 4;
constexpr std::size_t kMaxBuffers = 32;
constexpr double kUsPerSecond = 1e6;

std::string reason(int code) {
  return std::generic_category().message(-code);
}

std::int64_t now_ns(clockid_t clock) {
  timespec time{};
  clock_gettime(clock, &time);
  return static_cast<std::int64_t>(time.tv_sec) * 1'000'000'000 + time.tv_nsec;
}

std::string described(const libcamera::StreamConfiguration& stream) {
  return concat(stream.pixelFormat.toString(), " ",
                size_text(static_cast<int>(stream.size.width), static_cast<int>(stream.size.height)));
}

/// A configuration as requested that the camera accepts unchanged. Errors: kUnsupported (prints both).
Result<std::unique_ptr<libcamera::CameraConfiguration>> negotiate(libcamera::Camera& camera,
                                                                  const CaptureConfig& config,
                                                                  const CaptureInfo& info) {
  using libcamera::StreamRole;
  std::string set = "nothing";
  std::string asked;
  // Sensors without an image processor deliver in the raw role only.
  for (const StreamRole role : {StreamRole::VideoRecording, StreamRole::Viewfinder, StreamRole::Raw}) {
    auto configuration = camera.generateConfiguration({role});
    if (!configuration || configuration->empty()) {
      continue;
    }
    libcamera::StreamConfiguration& stream = configuration->at(0);
    stream.pixelFormat = libcamera_format(config.format);
    stream.size = {static_cast<unsigned>(config.width_px), static_cast<unsigned>(config.height_px)};
    stream.bufferCount = static_cast<unsigned>(config.buffers);
    const libcamera::StreamConfiguration wanted = stream;
    asked = described(wanted);
    const auto validity = configuration->validate();
    if (validity == libcamera::CameraConfiguration::Invalid) {
      continue;
    }
    if (stream.pixelFormat == wanted.pixelFormat && stream.size == wanted.size) {
      return configuration;
    }
    set = described(stream);
  }
  return fail(ErrorCode::kUnsupported, concat(info.name, ": asked for ", to_string(config.format), " (", asked,
                                              "), libcamera set ", set, "; `kinetrace doctor` lists the modes"));
}

// Caches may hold data from before the device wrote: announces begin and end of reading to drivers that need it.
void announce_reading(int dmabuf, std::uint64_t moment) {
  dma_buf_sync sync{};
  sync.flags = moment | DMA_BUF_SYNC_READ;
  ioctl(dmabuf, DMA_BUF_IOCTL_SYNC, &sync);
}

/// An open camera. Destroyed in the order that libcamera needs: requests, buffers, then the camera.
class Session {
 public:
  explicit Session(std::shared_ptr<libcamera::Camera> camera) : completed_(kMaxBuffers), camera_(std::move(camera)) {}
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
  ~Session();

  [[nodiscard]] Status open(const CaptureConfig& config, CaptureInfo& info);
  [[nodiscard]] Status start(const CaptureInfo& info);
  [[nodiscard]] Status stop(const CaptureInfo& info);
  [[nodiscard]] Result<CapturedImage> next(const CaptureInfo& info, std::chrono::milliseconds timeout);
  void release(int slot) noexcept;
  [[nodiscard]] int wait_fd() const noexcept { return completed_.wait_fd(); }

 private:
  struct Slot {
    std::unique_ptr<libcamera::Request> request;
    MappedBytes mapping;
    int dmabuf = -1;
    bool with_user = false;
    bool is_returning = false;  ///< libcamera has refused it.
  };

  [[nodiscard]] Status acquire(const CaptureConfig& config, CaptureInfo& info);
  [[nodiscard]] Status make_slot(libcamera::FrameBuffer& buffer, const CaptureInfo& info);
  int enqueue(Slot& slot, const libcamera::ControlList* controls = nullptr) noexcept;
  void retry_returns() noexcept;
  [[nodiscard]] Result<CapturedImage> image_of(const CompletedQueue::Item& item, const CaptureInfo& info);
  // Called in libcamera's thread.
  void on_completed(libcamera::Request* request);
  void on_disconnected() { completed_.end(); }

  CompletedQueue completed_;
  std::shared_ptr<libcamera::Camera> camera_;
  bool acquired_ = false;
  std::unique_ptr<libcamera::CameraConfiguration> configuration_;
  std::unique_ptr<libcamera::FrameBufferAllocator> allocator_;
  std::optional<libcamera::ControlList> controls_;
  SettingsCheck settings_;
  std::vector<Slot> slots_;
  bool streaming_ = false;
  std::int64_t last_sequence_ = -1;
  SequenceUnwrapper unwrapper_;  ///< Used by libcamera's thread while streaming.
};

Session::~Session() {
  if (streaming_) {
    camera_->stop();
  }
  camera_->requestCompleted.disconnect(this);
  camera_->disconnected.disconnect(this);
  slots_.clear();
  allocator_.reset();
  configuration_.reset();
  if (acquired_) {
    camera_->release();
  }
}

Status Session::acquire(const CaptureConfig& config, CaptureInfo& info) {
  info = {};
  info.name = concat(libcamera_name(*camera_), " (", camera_->id(), ")");
  info.stable_id = camera_->id();
  if (const int code = camera_->acquire(); code != 0) {
    return fail(ErrorCode::kIo, code == -EBUSY ? info.name + ": is in use by another program; close that one"
                                               : concat(info.name, ": libcamera does not hand it out: ", reason(code)));
  }
  acquired_ = true;
  auto configuration = negotiate(*camera_, config, info);
  if (!configuration) {
    return Unexpected(configuration.error());
  }
  configuration_ = std::move(*configuration);
  if (const int code = camera_->configure(configuration_.get()); code != 0) {
    return fail(ErrorCode::kIo, concat(info.name, ": configuring: ", reason(code)));
  }
  return {};
}

Status Session::open(const CaptureConfig& config, CaptureInfo& info) {
  if (Status acquired = acquire(config, info); !acquired) {
    return acquired;
  }
  const libcamera::StreamConfiguration& stream = configuration_->at(0);
  const auto location = camera_->properties().get(libcamera::properties::Location);
  info.format = config.format;
  info.width_px = config.width_px;
  info.height_px = config.height_px;
  info.stride_bytes = config.format == PixelFormat::kMjpeg ? 0 : static_cast<int>(stream.stride);
  info.timestamp_kind = TimestampKind::kStartOfExposure;
  // Drivers of USB cameras count delivered images, not those of the sensor.
  info.sequence_counts_losses = location != libcamera::properties::CameraLocationExternal;
  auto controls = choose_libcamera_controls(*camera_, config, info);
  if (!controls) {
    return Unexpected(controls.error());
  }
  controls_ = std::move(*controls);
  settings_ = SettingsCheck(
      {info.exposure_us, info.gain, info.rate_hz > 0.0 ? std::optional(kUsPerSecond / info.rate_hz) : std::nullopt});
  allocator_ = std::make_unique<libcamera::FrameBufferAllocator>(camera_);
  if (const int code = allocator_->allocate(stream.stream()); code < 0) {
    return fail(ErrorCode::kIo, concat(info.name, ": requesting buffers: ", reason(code)));
  }
  const auto& buffers = allocator_->buffers(stream.stream());
  if (buffers.size() < kMinBuffers) {
    return fail(ErrorCode::kUnsupported,
                concat(info.name, ": libcamera gave ", std::to_string(buffers.size()), " buffers, at least ",
                       std::to_string(kMinBuffers), " are needed; choose smaller images"));
  }
  for (std::size_t i = 0; i < std::min(buffers.size(), kMaxBuffers); ++i) {
    if (Status made = make_slot(*buffers[i], info); !made) {
      return made;
    }
  }
  camera_->requestCompleted.connect(this, &Session::on_completed);
  camera_->disconnected.connect(this, &Session::on_disconnected);
  return {};
}

// Luminance lies in the first plane of every format in use.
Status Session::make_slot(libcamera::FrameBuffer& buffer, const CaptureInfo& info) {
  const libcamera::FrameBuffer::Plane& plane = buffer.planes()[0];
  MappedBytes mapping(plane.fd.get(), plane.offset + plane.length, 0);
  if (!mapping.valid()) {
    return fail(ErrorCode::kIo, concat(info.name, ": mapping a buffer: ", reason(-errno)));
  }
  auto request = camera_->createRequest(slots_.size());
  if (!request || request->addBuffer(configuration_->at(0).stream(), &buffer) != 0) {
    return fail(ErrorCode::kIo, info.name + ": libcamera gives no request for a buffer");
  }
  slots_.push_back({std::move(request), std::move(mapping), plane.fd.get()});
  return {};
}

Status Session::start(const CaptureInfo& info) {
  completed_.clear();
  last_sequence_ = -1;
  unwrapper_.reset();
  settings_.reset();
  if (const int code = camera_->start(&*controls_); code != 0) {
    return completed_.ended() ? fail(ErrorCode::kDisconnected, info.name + ": the device has gone")
                              : fail(ErrorCode::kIo, concat(info.name, ": starting the stream: ", reason(code)));
  }
  streaming_ = true;
  // Some pipelines apply the controls of start(), others those of requests only.
  const libcamera::ControlList* controls = &*controls_;
  for (Slot& slot : slots_) {
    if (const int code = enqueue(slot, std::exchange(controls, nullptr)); code != 0) {
      const Status stopped = stop(info);
      return stopped ? fail(ErrorCode::kIo, concat(info.name, ": queueing a buffer: ", reason(code))) : stopped;
    }
  }
  return {};
}

Status Session::stop(const CaptureInfo& info) {
  streaming_ = false;
  const int code = camera_->stop();
  completed_.clear();
  for (Slot& slot : slots_) {
    slot.with_user = false;
    slot.is_returning = false;
  }
  if (code != 0 && !completed_.ended()) {
    return fail(ErrorCode::kIo, concat(info.name, ": stopping the stream: ", reason(code)));
  }
  return {};
}

// If libcamera refuses, the buffer waits for retry_returns().
int Session::enqueue(Slot& slot, const libcamera::ControlList* controls) noexcept {
  const ForeignCall foreign;
  slot.with_user = false;
  slot.request->reuse(libcamera::Request::ReuseBuffers);
  if (controls != nullptr) {
    slot.request->controls().merge(*controls);
  }
  const int code = camera_->queueRequest(slot.request.get());
  slot.is_returning = code != 0;
  return code;
}

void Session::retry_returns() noexcept {
  for (Slot& slot : slots_) {
    if (slot.is_returning && streaming_) {
      enqueue(slot);
    }
  }
}

void Session::on_completed(libcamera::Request* request) {
  // Runs in libcamera's thread, whose allocations count as foreign from here on.
  static thread_local const ForeignCall foreign;
  if (request->status() == libcamera::Request::RequestCancelled) {
    return;
  }
  const libcamera::FrameBuffer& buffer = *request->buffers().begin()->second;
  completed_.push({static_cast<int>(request->cookie()), unwrapper_.unwrap(buffer.metadata().sequence)});
}

Result<CapturedImage> Session::next(const CaptureInfo& info, std::chrono::milliseconds timeout) {
  retry_returns();
  while (wait_readable(completed_.wait_fd(), timeout)) {
    const auto item = completed_.pop();
    if (!item) {
      break;
    }
    // An image that completes after a newer one was delivered is skipped.
    if (item->sequence > last_sequence_) {
      return image_of(*item, info);
    }
    enqueue(slots_[static_cast<std::size_t>(item->slot)]);
  }
  if (completed_.ended()) {
    return fail(ErrorCode::kDisconnected, info.name + ": the device has gone; check its cable and power");
  }
  return fail(ErrorCode::kTimeout, "no image");  // Frequent: short enough for no allocation.
}

// Actual sensor settings of this image, as far as the pipeline handler reports them.
CaptureSettings settings_of(const libcamera::ControlList& metadata) {
  const auto as_real = [&metadata](const auto& control) {
    const auto value = metadata.get(control);
    return value ? std::optional(static_cast<double>(*value)) : std::nullopt;
  };
  return {as_real(libcamera::controls::ExposureTime), as_real(libcamera::controls::AnalogueGain),
          as_real(libcamera::controls::FrameDuration)};
}

Result<CapturedImage> Session::image_of(const CompletedQueue::Item& item, const CaptureInfo& info) {
  constexpr double kNanosecondsPerUs = 1e3;
  Slot& slot = slots_[static_cast<std::size_t>(item.slot)];
  const CaptureSettings got = settings_of(slot.request->metadata());
  if (const Status as_asked = settings_.check(info.name, got); !as_asked) {
    enqueue(slot);
    return Unexpected(as_asked.error());
  }
  slot.with_user = true;
  last_sequence_ = item.sequence;
  announce_reading(slot.dmabuf, DMA_BUF_SYNC_START);
  const libcamera::FrameBuffer& buffer = *slot.request->buffers().begin()->second;
  const libcamera::FrameMetadata& metadata = buffer.metadata();
  const auto stamp = slot.request->metadata().get(libcamera::controls::SensorTimestamp);
  const auto stamp_ns = stamp ? *stamp : static_cast<std::int64_t>(metadata.timestamp);
  const std::span<const std::byte> bytes = slot.mapping.bytes().subspan(buffer.planes()[0].offset);
  const std::size_t used = std::min<std::size_t>(metadata.planes()[0].bytesused, bytes.size());
  return CapturedImage{
      .slot = item.slot,
      .sequence = item.sequence,
      .timestamp_ns = to_monotonic_ns(stamp_ns, {now_ns(CLOCK_MONOTONIC), now_ns(CLOCK_BOOTTIME)}),
      .damaged = metadata.status != libcamera::FrameMetadata::FrameSuccess || used < bytes_needed(info),
      .data = bytes.first(used),
      .exposure_ns = got.exposure_us ? std::optional(std::int64_t{std::llround(*got.exposure_us * kNanosecondsPerUs)})
                                     : std::nullopt,
      .dmabuf_fd = slot.dmabuf,
      .dmabuf_offset_bytes = buffer.planes()[0].offset};
}

void Session::release(int slot) noexcept {
  const auto index = static_cast<std::size_t>(slot);
  if (streaming_ && slot >= 0 && index < slots_.size() && slots_[index].with_user) {
    announce_reading(slots_[index].dmabuf, DMA_BUF_SYNC_END);
    enqueue(slots_[index]);
  }
}

class LibcameraDevice final : public CaptureDevice {
 public:
  explicit LibcameraDevice(const CaptureConfig& config) : config_(config) {}

  Status open() override;
  Status start() override { return session_ ? session_->start(info_) : not_open(); }
  Result<CapturedImage> next(std::chrono::milliseconds timeout) override {
    return session_ ? session_->next(info_, timeout) : Unexpected(not_open().error());
  }
  void release(int slot) noexcept override {
    if (session_) {
      session_->release(slot);
    }
  }
  Status stop() override { return session_ ? session_->stop(info_) : not_open(); }
  void close() noexcept override { session_.reset(); }
  int wait_fd() const noexcept override { return session_ ? session_->wait_fd() : -1; }
  const CaptureInfo& info() const noexcept override { return info_; }

 private:
  [[nodiscard]] Status not_open() const { return fail(ErrorCode::kIllegalState, config_.device + ": is not open"); }

  CaptureConfig config_;
  CaptureInfo info_;
  std::unique_ptr<Session> session_;
};

Status LibcameraDevice::open() {
  auto camera = find_libcamera(config_.device);
  if (!camera) {
    return Unexpected(camera.error());
  }
  auto session = std::make_unique<Session>(std::move(*camera));
  if (Status opened = session->open(config_, info_); !opened) {
    return opened;
  }
  session_ = std::move(session);
  return {};
}

std::vector<std::string> list_modes(libcamera::Camera& camera) {
  std::vector<std::string> modes;
  const auto configuration = camera.generateConfiguration({libcamera::StreamRole::VideoRecording});
  if (!configuration || configuration->empty()) {
    return modes;
  }
  const libcamera::StreamFormats& formats = configuration->at(0).formats();
  for (const PixelFormat format : {PixelFormat::kGrey8, PixelFormat::kGrey10, PixelFormat::kGrey16, PixelFormat::kYuyv,
                                   PixelFormat::kNv12, PixelFormat::kMjpeg}) {
    for (const libcamera::Size& size : formats.sizes(libcamera_format(format))) {
      modes.push_back(
          concat(to_string(format), " ", size_text(static_cast<int>(size.width), static_cast<int>(size.height))));
    }
  }
  return modes;
}

}  // namespace

std::unique_ptr<CaptureDevice> make_libcamera_device(const CaptureConfig& config) {
  return std::make_unique<LibcameraDevice>(config);
}

std::vector<CaptureListing> list_libcamera_devices() {
  std::vector<CaptureListing> listings;
  const auto manager = libcamera_manager();
  if (!manager) {
    return listings;
  }
  for (const std::shared_ptr<libcamera::Camera>& camera : (*manager)->cameras()) {
    listings.push_back({.backend = CaptureBackend::kLibcamera,
                        .path = {},
                        .stable_id = camera->id(),
                        .name = libcamera_name(*camera),
                        .modes = list_modes(*camera)});
  }
  return listings;
}

}  // namespace kinetrace::hal

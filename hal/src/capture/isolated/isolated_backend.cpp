#include "capture/isolated/isolated_backend.hpp"

#include <array>
#include <unistd.h>
#include <utility>
#include <vector>

#include "capture/isolated/isolated_protocol.hpp"
#include "capture/isolated/isolated_spawner.hpp"
#include "capture/mapped_bytes.hpp"
#include "util/deadline.hpp"
#include "util/messages.hpp"

namespace kinetrace::hal {
namespace {

/// A buffer shared by the other process.
struct SharedBuffer {
  explicit SharedBuffer(OwnedFd file)
      : mapping(file.get(), static_cast<std::size_t>(std::max<off_t>(lseek(file.get(), 0, SEEK_END), 0)), 0),
        descriptor(std::move(file)) {}
  MappedBytes mapping;
  OwnedFd descriptor;
};

class IsolatedDevice final : public CaptureDevice {
 public:
  IsolatedDevice(CaptureConfig config, std::string library, std::shared_ptr<IsolatedSpawner> spawner)
      : config_(std::move(config)), library_(std::move(library)), spawner_(std::move(spawner)), room_(kMaxAnswerBytes) {
    buffers_.resize(kMaxSlots);
  }
  ~IsolatedDevice() override { close(); }

  Status open() override;
  Status start() override;
  Result<CapturedImage> next(std::chrono::milliseconds timeout) override;
  void release(int slot) noexcept override;
  Status stop() override;
  void close() noexcept override;
  int wait_fd() const noexcept override { return process_ ? process_->images().fd() : -1; }
  const CaptureInfo& info() const noexcept override { return info_; }

 private:
  [[nodiscard]] std::string name() const { return info_.name.empty() ? config_.device : info_.name; }
  [[nodiscard]] Status call(const PacketWriter& packet);
  [[nodiscard]] Unexpected<Error> gone() const;
  [[nodiscard]] Result<CapturedImage> image_of(const IsolatedEvent& event, OwnedFd descriptor);

  CaptureConfig config_;
  std::string library_;
  std::shared_ptr<IsolatedSpawner> spawner_;
  CaptureInfo info_;
  std::unique_ptr<IsolatedProcess> process_;
  std::vector<std::byte> room_;  ///< For answers.
  std::vector<std::optional<SharedBuffer>> buffers_;
  std::uint64_t stream_ = 0;  ///< Number of starts; the worker counts them as well.
};

Unexpected<Error> IsolatedDevice::gone() const {
  return fail(ErrorCode::kDisconnected,
              concat(name(), ": the process that runs ", library_, " for it crashed or hangs; it is started again"));
}

Status IsolatedDevice::call(const PacketWriter& packet) {
  if (!process_) {
    return fail(ErrorCode::kIllegalState, config_.device + ": is not open");
  }
  const auto bytes = process_->call(packet, room_);
  if (bytes.empty()) {
    return gone();
  }
  PacketReader answer(bytes);
  return take_status(answer);
}

Status IsolatedDevice::open() {
  close();
  auto process = spawner_->spawn();
  if (!process) {
    return fail(ErrorCode::kIo, concat(config_.device, ": ", process.error().message));
  }
  PacketWriter packet;
  packet.put(IsolatedCall::kOpen);
  put(packet, config_);
  const auto bytes = (*process)->call(packet, room_);
  if (bytes.empty()) {
    return gone();
  }
  PacketReader answer(bytes);
  if (Status opened = take_status(answer); !opened) {
    return opened;
  }
  info_ = take_info(answer);
  process_ = std::move(*process);
  return {};
}

Status IsolatedDevice::start() {
  ++stream_;
  return call(PacketWriter().put(IsolatedCall::kStart));
}

Status IsolatedDevice::stop() {
  return call(PacketWriter().put(IsolatedCall::kStop));
}

void IsolatedDevice::close() noexcept {
  process_.reset();
  for (auto& buffer : buffers_) {
    buffer.reset();
  }
  stream_ = 0;
}

Result<CapturedImage> IsolatedDevice::next(std::chrono::milliseconds timeout) {
  if (!process_) {
    return fail(ErrorCode::kIllegalState, config_.device + ": is not open");
  }
  const Deadline deadline(timeout);
  do {
    IsolatedEvent event;
    auto got = process_->images().receive(std::as_writable_bytes(std::span(&event, 1)), deadline.left());
    if (got && got->bytes != sizeof event) {
      return gone();
    }
    if (!got) {
      continue;
    }
    const bool is_current = event.stream == stream_;
    if (event.is_image) {
      // Also for images of a previous stream: each buffer is announced only once.
      auto image = image_of(event, std::move(got->descriptors[0]));
      if (is_current) {
        return image;
      }
    } else if (is_current) {
      return fail(event.error, event.message.data());
    }
  } while (!deadline.is_over());
  return fail(ErrorCode::kTimeout, "no image");  // Frequent: short enough for no allocation.
}

Result<CapturedImage> IsolatedDevice::image_of(const IsolatedEvent& event, OwnedFd descriptor) {
  auto& buffer = buffers_.at(static_cast<std::size_t>(event.slot));
  if (descriptor.valid()) {
    buffer.emplace(std::move(descriptor));
  }
  const auto bytes = buffer ? buffer->mapping.bytes() : std::span<const std::byte>();
  const bool fits = event.offset_bytes <= bytes.size() && event.size_bytes <= bytes.size() - event.offset_bytes;
  return CapturedImage{.slot = event.slot,
                       .sequence = event.sequence,
                       .timestamp_ns = event.timestamp_ns,
                       .damaged = event.damaged || !fits,
                       .data = fits ? bytes.subspan(event.offset_bytes, event.size_bytes) : bytes.first(0),
                       .exposure_ns = event.exposure_ns == IsolatedEvent::kUnknownExposure
                                          ? std::nullopt
                                          : std::optional(event.exposure_ns),
                       .dmabuf_fd = buffer ? std::optional(buffer->descriptor.get()) : std::nullopt,
                       .dmabuf_offset_bytes = event.offset_bytes};
}

void IsolatedDevice::release(int slot) noexcept {
  if (process_) {
    // If sending fails the process hangs; its missing images then report that.
    static_cast<void>(process_->images().send(packet_of(IsolatedRelease{stream_, slot})));
  }
}

std::vector<CaptureListing> list_isolated(const IsolatedSpawner& spawner, const std::string& library) {
  const auto process = spawner.spawn();
  std::vector<std::byte> room(kMaxAnswerBytes);
  PacketReader answer(process ? (*process)->call(PacketWriter().put(IsolatedCall::kList), room)
                              : std::span<const std::byte>());
  const Status status = take_status(answer);
  auto listings = take_listings(answer);
  if (!status || !answer.complete()) {
    CaptureListing unknown{
        .backend = CaptureBackend::kLibcamera, .path = {}, .stable_id = {}, .name = library, .modes = {}};
    unknown.problem = concat(library, " crashed or hangs while it looks for cameras; try again");
    return {unknown};
  }
  return listings;
}

}  // namespace

CaptureBackendEntry isolate(const CaptureBackendEntry& backend, const std::string& library) {
  const auto spawner = IsolatedSpawner::start(backend);
  if (!spawner) {
    return backend;  // Better without isolation than without a camera.
  }
  return {[spawner = *spawner, library](const CaptureConfig& config) -> std::unique_ptr<CaptureDevice> {
            return std::make_unique<IsolatedDevice>(config, library, spawner);
          },
          [spawner = *spawner, library] { return list_isolated(*spawner, library); }};
}

}  // namespace kinetrace::hal

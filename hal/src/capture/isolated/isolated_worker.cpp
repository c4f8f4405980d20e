#include "capture/isolated/isolated_worker.hpp"

#include <algorithm>
#include <bitset>
#include <cerrno>
#include <memory>
#include <poll.h>
#include <unistd.h>

#include "capture/isolated/isolated_protocol.hpp"

namespace kinetrace::hal {
namespace {

constexpr std::chrono::milliseconds kNoWait{0};

class Worker {
 public:
  Worker(const CaptureBackendEntry& backend, PacketSocket calls, PacketSocket images)
      : backend_(backend), calls_(std::move(calls)), images_(std::move(images)) {}

  /// False after the other side has closed.
  [[nodiscard]] bool work() {
    std::array<pollfd, 3> files{pollfd{calls_.fd(), POLLIN, 0}, pollfd{images_.fd(), POLLIN, 0},
                                pollfd{streaming_ ? device_->wait_fd() : -1, POLLIN, 0}};
    if (poll(files.data(), files.size(), -1) < 0) {
      return errno == EINTR;
    }
    if (files[1].revents != 0 && !take_release()) {
      return false;
    }
    if (files[0].revents != 0 && !answer_call()) {
      return false;
    }
    if (files[2].revents != 0 && streaming_) {
      send_image();
    }
    return true;
  }

 private:
  [[nodiscard]] bool take_release() {
    IsolatedRelease back;
    const auto got = images_.receive(std::as_writable_bytes(std::span(&back, 1)), kNoWait);
    if (got && got->bytes == sizeof back && back.stream == stream_ && streaming_) {
      device_->release(static_cast<int>(back.slot));
    }
    return !got || got->bytes > 0;
  }

  [[nodiscard]] bool answer_call() {
    const auto got = calls_.receive(room_, kNoWait);
    if (!got || got->bytes == 0) {
      return !got;
    }
    PacketReader call(std::span<const std::byte>(room_).first(got->bytes));
    PacketWriter answer;
    switch (call.take<IsolatedCall>()) {
      case IsolatedCall::kList: put(answer, Status{}), put(answer, backend_.list()); break;
      case IsolatedCall::kOpen: open(take_config(call), answer); break;
      case IsolatedCall::kStart: put(answer, start()); break;
      case IsolatedCall::kStop: put(answer, stop()); break;
    }
    return calls_.send(answer.bytes());
  }

  void open(const CaptureConfig& config, PacketWriter& answer) {
    device_ = backend_.make(config);
    const Status opened = device_->open();
    put(answer, opened);
    put(answer, device_->info());
  }
  [[nodiscard]] Status start() {
    ++stream_;
    Status started = device_->start();
    streaming_ = static_cast<bool>(started);
    return started;
  }
  [[nodiscard]] Status stop() {
    streaming_ = false;
    return device_->stop();
  }

  void send_image() {
    const auto image = device_->next(kNoWait);
    IsolatedEvent event{.stream = stream_};
    if (!image) {
      // After an error no image is sent until the stream is started again.
      streaming_ = image.error().code == ErrorCode::kTimeout;
      if (!streaming_) {
        event.error = image.error().code;
        const std::string& message = image.error().message;
        std::copy_n(message.begin(), std::min(message.size(), event.message.size() - 1), event.message.begin());
        static_cast<void>(images_.send(packet_of(event)));
      }
      return;
    }
    event.is_image = true;
    event.damaged = image->damaged || !image->dmabuf_fd;
    event.slot = image->slot;
    event.sequence = image->sequence;
    event.timestamp_ns = image->timestamp_ns;
    event.offset_bytes = image->dmabuf_offset_bytes;
    event.size_bytes = image->data.size();
    event.exposure_ns = image->exposure_ns.value_or(IsolatedEvent::kUnknownExposure);
    const auto slot = static_cast<std::size_t>(image->slot);
    const bool is_known = slot < known_.size() && known_[slot];
    const int descriptor = image->dmabuf_fd.value_or(-1);
    const bool sent = slot < known_.size() &&
                      images_.send(packet_of(event), std::span(&descriptor, is_known || descriptor < 0 ? 0 : 1));
    if (!sent) {
      device_->release(image->slot);
      return;
    }
    known_.set(slot);
  }

  const CaptureBackendEntry& backend_;
  PacketSocket calls_;
  PacketSocket images_;
  std::unique_ptr<CaptureDevice> device_;
  std::uint64_t stream_ = 0;
  bool streaming_ = false;
  std::bitset<kMaxSlots> known_;  ///< Buffers whose descriptor the other side has.
  std::array<std::byte, kMaxAnswerBytes> room_{};
};

}  // namespace

void serve_device(const CaptureBackendEntry& backend, PacketSocket calls, PacketSocket images) {
  const auto worker = std::make_unique<Worker>(backend, std::move(calls), std::move(images));
  while (worker->work()) {
  }
  _exit(0);
}

}  // namespace kinetrace::hal

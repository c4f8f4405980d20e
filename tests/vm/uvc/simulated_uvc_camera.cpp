#include "simulated_uvc_camera.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <stdexcept>
#include <sys/socket.h>
#include <unistd.h>

#include <turbojpeg.h>

namespace kinetrace::hal::test {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::nanoseconds;

constexpr std::uint8_t kHeaderBytes = 2;
const std::string kController = "/sys/devices/platform/vhci_hcd.0/";

// The moment from which all cameras count their frames.
Clock::time_point beginning() {
  static const Clock::time_point moment = Clock::now();
  return moment;
}

void write_attribute(const std::string& name, const std::string& text) {
  const int file = ::open((kController + name).c_str(), O_WRONLY | O_CLOEXEC);
  const ssize_t written = file < 0 ? -1 : ::write(file, text.data(), text.size());
  const int error = errno;
  if (file >= 0) {
    ::close(file);
  }
  if (written < 0) {
    throw std::runtime_error(kController + name + ": " + std::strerror(error));
  }
}

Bytes interleave_chroma(const Bytes& luminance) {
  constexpr std::uint8_t kColourless = 128;
  Bytes yuyv(luminance.size() * 2, kColourless);
  for (std::size_t i = 0; i < luminance.size(); ++i) {
    yuyv[2 * i] = luminance[i];
  }
  return yuyv;
}

Bytes compress(const Bytes& luminance, int width, int height) {
  constexpr int kQuality = 90;
  const tjhandle encoder = tjInitCompress();
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  const int code =
      tjCompress2(encoder, luminance.data(), width, width, height, TJPF_GRAY, &bytes, &size, TJSAMP_GRAY, kQuality, 0);
  Bytes jpeg(bytes, bytes + (code == 0 ? size : 0));
  tjFree(bytes);
  tjDestroy(encoder);
  return jpeg;
}

}  // namespace

SimulatedUvcCamera::SimulatedUvcCamera(int view)
    : view_(view), function_(view == 0 ? "Simulated Stereo Left" : "Simulated Stereo Right", serial()) {
  beginning();
}

SimulatedUvcCamera::~SimulatedUvcCamera() {
  if (connection_) {
    unplug();
  }
}

std::string SimulatedUvcCamera::serial() const {
  return "SIM100" + std::to_string(view_);
}

std::string SimulatedUvcCamera::bus_id() const {
  return "usb-vhci_hcd.0-" + std::to_string(view_ + 1);
}

void SimulatedUvcCamera::plug() {
  constexpr int kHighSpeed = 3;
  constexpr int kBus = 1 << 16;
  constexpr int kSocketBytes = 1 << 20;
  std::array<int, 2> ends{};
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    throw std::runtime_error(std::string("socketpair: ") + std::strerror(errno));
  }
  for (const int end : ends) {
    setsockopt(end, SOL_SOCKET, SO_SNDBUF, &kSocketBytes, sizeof kSocketBytes);
  }
  function_.reset();
  connection_ = std::make_unique<UsbipConnection>(ends[0]);
  plugged_ = true;
  answering_ = std::thread([this] { answer_requests(); });
  streaming_ = std::thread([this] { stream_frames(); });
  const std::string device = std::to_string(kBus | (view_ + 2));
  write_attribute("attach", std::to_string(view_) + " " + std::to_string(ends[1]) + " " + device + " " +
                                std::to_string(kHighSpeed));
  ::close(ends[1]);
}

void SimulatedUvcCamera::unplug() {
  write_attribute("detach", std::to_string(view_));
  {
    const std::lock_guard lock(mutex_);
    plugged_ = false;
  }
  changed_.notify_all();
  connection_->shut_down();
  answering_.join();
  streaming_.join();
  connection_.reset();
  transfers_.clear();
  early_unlinks_.clear();
  last_submitted_ = 0;
}

void SimulatedUvcCamera::answer_requests() {
  constexpr int kStall = -EPIPE;
  while (const auto request = connection_->receive()) {
    if (request->kind == UsbipRequest::Kind::kUnlink) {
      unlink(*request);
      continue;
    }
    note_submission(*request);
    if (request->endpoint == 0) {
      const auto answer = function_.answer(UsbSetup(request->setup), request->sent);
      connection_->reply(request->sequence, answer ? 0 : kStall, answer.value_or(Bytes{}),
                         static_cast<std::uint32_t>(request->sent.size()));
    } else {
      queue(*request);
    }
  }
}

void SimulatedUvcCamera::note_submission(const UsbipRequest& request) {
  const std::lock_guard lock(mutex_);
  last_submitted_ = request.sequence;
}

void SimulatedUvcCamera::queue(const UsbipRequest& request) {
  const std::lock_guard lock(mutex_);
  const auto early = std::find_if(early_unlinks_.begin(), early_unlinks_.end(), [&](const UsbipRequest& unlink) {
    return unlink.unlinked_sequence == request.sequence;
  });
  if (early != early_unlinks_.end()) {
    connection_->reply_unlink(early->sequence, true);
    early_unlinks_.erase(early);
    return;
  }
  transfers_.push_back({request.sequence, request.length});
  changed_.notify_all();
}

// The kernel may send this before the transfer that it names. Denying it then would leave that transfer waiting for
// ever; answering the transfer later would end the connection.
void SimulatedUvcCamera::unlink(const UsbipRequest& request) {
  const std::lock_guard replying(replying_);
  const std::lock_guard lock(mutex_);
  if (request.unlinked_sequence > last_submitted_) {
    early_unlinks_.push_back(request);
    return;
  }
  const auto found =
      std::erase_if(transfers_, [&](const Transfer& waiting) { return waiting.sequence == request.unlinked_sequence; });
  connection_->reply_unlink(request.sequence, found > 0);
}

bool SimulatedUvcCamera::wait_for_transfer() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return !plugged_ || !transfers_.empty(); });
  return plugged_;
}

// One frame a period, at the same times for every camera. Pictures are drawn ahead.
void SimulatedUvcCamera::stream_frames() {
  constexpr int kLatestPart = 4;
  while (wait_for_transfer()) {
    const auto streaming = function_.streaming();
    if (!streaming) {
      std::this_thread::yield();
      continue;
    }
    const nanoseconds period(streaming->period_ns);
    const auto index = (Clock::now() - beginning()) / period + 1;
    const Clock::time_point due = beginning() + index * period;
    const Bytes payload = make_payload(*streaming, static_cast<std::uint32_t>(index));
    std::this_thread::sleep_until(due);
    if (stalled_ || !wait_for_transfer()) {
      continue;
    }
    if (drop_ > 0) {
      --drop_;
      continue;
    }
    if (Clock::now() - due < period / kLatestPart) {
      send_payload(payload, *streaming);
    }
  }
}

// UVC 2.4.3.3: two bytes of header, here once a frame, and the image.
Bytes SimulatedUvcCamera::make_payload(const UvcFunction::Streaming& streaming, std::uint32_t index) {
  constexpr std::uint8_t kEndOfHeader = 0x80;
  constexpr std::uint8_t kEndOfFrame = 0x02;
  const UvcMode& mode = streaming.mode;
  Bytes luminance(static_cast<std::size_t>(mode.width * mode.height));
  const MutableGrayView image{luminance.data(), mode.width, mode.height, mode.width};
  if (!pictures_.empty()) {
    const Bytes& picture = pictures_[index / static_cast<std::uint32_t>(frames_each_) % pictures_.size()];
    std::copy_n(picture.begin(), std::min(picture.size(), luminance.size()), luminance.begin());
  } else if (mode.width >= 2 * kMarkWidth_px) {
    const int half = mode.width / 2;
    draw_frame({image.data, half, image.height, image.stride}, {index, 0}, function_.brightness());
    draw_frame({image.data + half, half, image.height, image.stride}, {index, 1}, function_.brightness());
  } else {
    draw_frame(image, {index, view_}, function_.brightness());
  }
  Bytes content = luminance;
  if (mode.format == UvcFormat::kYuyv) {
    content = interleave_chroma(luminance);
  } else if (mode.format == UvcFormat::kMjpeg) {
    content = compress(luminance, mode.width, mode.height);
  }
  if (cut_ > 0) {
    --cut_;
    content.resize(content.size() / 2);
  }
  Bytes payload(kHeaderBytes + content.size());
  payload[0] = kHeaderBytes;
  payload[1] = static_cast<std::uint8_t>(kEndOfHeader | kEndOfFrame | (frame_id_ ? 1U : 0U));
  std::copy(content.begin(), content.end(), payload.begin() + kHeaderBytes);
  frame_id_ = !frame_id_;
  return payload;
}

// A partly filled transfer ends the payload; an exactly filled one is followed by an empty one. The rest of a frame of
// an earlier stream is not sent.
void SimulatedUvcCamera::send_payload(const Bytes& payload, const UvcFunction::Streaming& streaming) {
  const std::size_t longest = streaming.mode.frame_bytes() + kHeaderBytes;
  std::size_t sent = 0;
  bool is_ended = false;
  while (!is_ended && wait_for_transfer()) {
    const std::lock_guard replying(replying_);
    if (const auto now = function_.streaming(); !now || now->generation != streaming.generation) {
      return;
    }
    Transfer transfer;
    {
      const std::lock_guard lock(mutex_);
      if (transfers_.empty()) {
        continue;  // Unlinked meanwhile.
      }
      transfer = transfers_.front();
      transfers_.pop_front();
    }
    const std::size_t count = std::min<std::size_t>(transfer.room, payload.size() - sent);
    connection_->reply(transfer.sequence, 0, std::span(payload).subspan(sent, count));
    sent += count;
    is_ended = count < transfer.room || sent == longest;
  }
}

}  // namespace kinetrace::hal::test

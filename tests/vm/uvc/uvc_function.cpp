#include "uvc_function.hpp"

#include <algorithm>
#include <cstdlib>
#include <utility>

namespace kinetrace::hal::test {
namespace {

// Requests of the video class (UVC A.8).
enum UvcRequest : std::uint8_t {
  kSetCur = 0x01,
  kGetCur = 0x81,
  kGetMin = 0x82,
  kGetMax = 0x83,
  kGetRes = 0x84,
  kGetLen = 0x85,
  kGetInfo = 0x86,
  kGetDef = 0x87,
};

constexpr std::uint8_t kReadAndWrite = 3;
// Places in the probe and commit control.
constexpr std::size_t kFormatIndex = 2;
constexpr std::size_t kFrameIndex = 3;
constexpr std::size_t kInterval = 4;
constexpr std::size_t kMaxFrameSize = 18;
constexpr std::size_t kMaxPayload = 22;
constexpr std::size_t kClock = 26;
constexpr std::size_t kFraming = 30;

std::uint32_t read32(std::span<const std::uint8_t> bytes, std::size_t place) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    value |= static_cast<std::uint32_t>(bytes[place + i]) << (8 * i);
  }
  return value;
}

void write(std::span<std::uint8_t> bytes, std::size_t place, std::size_t count, std::uint32_t value) {
  for (std::size_t i = 0; i < count; ++i) {
    bytes[place + i] = static_cast<std::uint8_t>(value >> (8 * i));
  }
}

Bytes little_endian(int value, std::size_t count) {
  Bytes bytes(count);
  write(bytes, 0, count, static_cast<std::uint32_t>(value));
  return bytes;
}

std::uint32_t nearest_interval(std::uint32_t wanted) {
  const auto distance = [wanted](std::uint32_t interval) {
    return std::abs(static_cast<std::int64_t>(interval) - static_cast<std::int64_t>(wanted));
  };
  return *std::min_element(kUvcIntervals.begin(), kUvcIntervals.end(),
                           [&](std::uint32_t a, std::uint32_t b) { return distance(a) < distance(b); });
}

}  // namespace

UsbSetup::UsbSetup(std::span<const std::uint8_t, 8> bytes)
    : request_type(bytes[0]),
      request(bytes[1]),
      value(static_cast<std::uint16_t>(bytes[2] | (bytes[3] << 8))),
      index(static_cast<std::uint16_t>(bytes[4] | (bytes[5] << 8))),
      length(static_cast<std::uint16_t>(bytes[6] | (bytes[7] << 8))) {}

UvcFunction::UvcFunction(std::string product, std::string serial)
    : product_(std::move(product)), serial_(std::move(serial)) {
  reset();
}

void UvcFunction::reset() {
  constexpr int kManual = 1;
  constexpr int kAperturePriority = 8;
  const std::lock_guard lock(mutex_);
  probe_ = {};
  probe_[kFormatIndex] = 1;
  probe_[kFrameIndex] = 1;
  complete(probe_);
  committed_.reset();
  controls_[kExposureMode] = {kCameraTerminal, 2, 1, 0, 255, kManual | kAperturePriority, kAperturePriority, 0};
  controls_[kExposureTime] = {kCameraTerminal, 4, 4, 1, 10'000, 1, 100, 0};
  controls_[kBrightness] = {kProcessingUnit, 2, 2, 0, 255, 1, 0, 0};
  controls_[kGain] = {kProcessingUnit, 4, 2, 1, 255, 1, 16, 0};
  for (Control& control : controls_) {
    control.current = control.standard;
  }
}

// Replaces the host's proposal by the nearest one that the device supports.
void UvcFunction::complete(Probe& probe) {
  const UvcMode mode = find_mode(probe[kFormatIndex], probe[kFrameIndex]);
  const std::uint32_t wanted = read32(probe, kInterval);
  constexpr std::uint32_t kHeaderBytes = 2;
  probe[kFormatIndex] = static_cast<std::uint8_t>(mode.format);
  probe[kFrameIndex] = static_cast<std::uint8_t>(mode.frame);
  write(probe, kInterval, 4, wanted == 0 ? kUvcDefaultInterval : nearest_interval(wanted));
  write(probe, kMaxFrameSize, 4, mode.frame_bytes());
  write(probe, kMaxPayload, 4, mode.frame_bytes() + kHeaderBytes);
  write(probe, kClock, 4, kUvcClock_hz);
  probe[kFraming] = 3;  // Frame id and end of frame are in the headers.
}

std::optional<UvcFunction::Streaming> UvcFunction::streaming() const {
  constexpr std::int64_t kNanosecondsPerUnit = 100;
  const std::lock_guard lock(mutex_);
  if (!committed_) {
    return std::nullopt;
  }
  return Streaming{find_mode((*committed_)[kFormatIndex], (*committed_)[kFrameIndex]),
                   read32(*committed_, kInterval) * kNanosecondsPerUnit, generation_};
}

int UvcFunction::brightness() const {
  constexpr int kUnitGain = 16;
  const std::lock_guard lock(mutex_);
  return std::min(255, controls_[kExposureTime].current * controls_[kGain].current / kUnitGain);
}

std::optional<Bytes> UvcFunction::answer(const UsbSetup& setup, std::span<const std::uint8_t> sent) {
  constexpr unsigned kTypeMask = 0x60;
  constexpr unsigned kClassRequest = 0x20;
  constexpr unsigned kStreamingInterface = 1;
  const unsigned type = setup.request_type & kTypeMask;
  std::optional<Bytes> reply;
  if (type == 0) {
    reply = standard_answer(setup);
  } else if (type == kClassRequest && (setup.index & 0xffU) == kStreamingInterface) {
    reply = streaming_answer(setup, sent);
  } else if (type == kClassRequest) {
    reply = control_answer(setup, sent);
  }
  if (reply && reply->size() > setup.length) {
    reply->resize(setup.length);
  }
  return reply;
}

// USB 2.0, 9.4.
std::optional<Bytes> UvcFunction::standard_answer(const UsbSetup& setup) const {
  constexpr std::uint8_t kGetStatus = 0;
  constexpr std::uint8_t kGetDescriptor = 6;
  constexpr std::uint8_t kGetConfiguration = 8;
  constexpr std::uint8_t kGetInterface = 10;
  if (!setup.is_read()) {
    return Bytes{};  // Any configuration, interface and feature is accepted: there is one of each.
  }
  switch (setup.request) {
    case kGetStatus: return Bytes{0, 0};
    case kGetConfiguration: return Bytes{1};
    case kGetInterface: return Bytes{0};
    case kGetDescriptor: break;
    default: return std::nullopt;
  }
  switch (setup.value >> 8U) {
    case 1: return device_descriptor();
    case 2: return configuration_descriptor();
    case 3: return string_descriptor(setup.value & 0xff, product_, serial_);
    case 6: return qualifier_descriptor();
    default: return std::nullopt;
  }
}

std::optional<Bytes> UvcFunction::streaming_answer(const UsbSetup& setup, std::span<const std::uint8_t> sent) {
  constexpr unsigned kCommit = 2;
  constexpr std::size_t kVersion10Bytes = 26;
  const bool is_commit = setup.value >> 8U == kCommit;
  const std::lock_guard lock(mutex_);
  switch (setup.request) {
    case kSetCur:
      if (sent.size() < kVersion10Bytes) {
        return std::nullopt;
      }
      std::copy_n(sent.begin(), std::min(sent.size(), kProbeBytes), probe_.begin());
      complete(probe_);
      if (is_commit) {
        committed_ = probe_;
        ++generation_;
      }
      return Bytes{};
    case kGetCur:
    case kGetMin:
    case kGetMax:
    case kGetDef: {
      const Probe& probe = is_commit && committed_ ? *committed_ : probe_;
      return Bytes(probe.begin(), probe.end());
    }
    case kGetLen: return little_endian(kProbeBytes, 2);
    case kGetInfo: return Bytes{kReadAndWrite};
    default: return std::nullopt;
  }
}

std::optional<Bytes> UvcFunction::control_answer(const UsbSetup& setup, std::span<const std::uint8_t> sent) {
  const std::lock_guard lock(mutex_);
  const auto control = std::find_if(controls_.begin(), controls_.end(), [&setup](const Control& known) {
    return known.unit == setup.index >> 8U && known.selector == setup.value >> 8U;
  });
  if (control == controls_.end()) {
    return std::nullopt;
  }
  switch (setup.request) {
    case kGetCur: return little_endian(control->current, control->bytes);
    case kGetMin: return little_endian(control->minimum, control->bytes);
    case kGetMax: return little_endian(control->maximum, control->bytes);
    case kGetRes: return little_endian(control->resolution, control->bytes);
    case kGetDef: return little_endian(control->standard, control->bytes);
    case kGetLen: return little_endian(static_cast<int>(control->bytes), 2);
    case kGetInfo: return Bytes{kReadAndWrite};
    case kSetCur: {
      std::array<std::uint8_t, 4> value{};
      std::copy_n(sent.begin(), std::min(sent.size(), value.size()), value.begin());
      control->current = static_cast<int>(read32(value, 0));
      return Bytes{};
    }
    default: return std::nullopt;
  }
}

}  // namespace kinetrace::hal::test

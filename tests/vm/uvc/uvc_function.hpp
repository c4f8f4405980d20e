// The control side of the simulated camera: answers to requests on endpoint 0.
#pragma once

#include <array>
#include <cstdint>
#include <mutex>
#include <optional>
#include <span>
#include <string>

#include "uvc_descriptors.hpp"

namespace kinetrace::hal::test {

/// The eight bytes of a request (USB 2.0, 9.3).
struct UsbSetup {
  std::uint8_t request_type = 0;
  std::uint8_t request = 0;
  std::uint16_t value = 0;
  std::uint16_t index = 0;
  std::uint16_t length = 0;
  explicit UsbSetup(std::span<const std::uint8_t, 8> bytes);
  [[nodiscard]] bool is_read() const { return (request_type & 0x80U) != 0; }
};

/// Used by the thread that answers requests; `streaming` and `brightness` may be asked by another.
class UvcFunction {
 public:
  UvcFunction(std::string product, std::string serial);

  /// The device's answer; none: it stalls the request. `sent` is the host's data.
  [[nodiscard]] std::optional<Bytes> answer(const UsbSetup& setup, std::span<const std::uint8_t> sent);

  struct Streaming {
    UvcMode mode;
    std::int64_t period_ns = 0;
    int generation = 0;  ///< Changes whenever a stream begins.
  };
  /// The stream that the host has committed to; none before.
  [[nodiscard]] std::optional<Streaming> streaming() const;
  /// Exposure time times gain, as the sensor would see it: 0 to 255.
  [[nodiscard]] int brightness() const;
  /// Plugged in anew: nothing committed, every control at its default.
  void reset();

 private:
  static constexpr std::size_t kProbeBytes = 34;
  using Probe = std::array<std::uint8_t, kProbeBytes>;  ///< UVC 4.3.1.1.

  struct Control {
    std::uint8_t unit = 0;
    std::uint8_t selector = 0;
    std::size_t bytes = 0;
    int minimum = 0;
    int maximum = 0;
    int resolution = 0;  ///< For the exposure mode: the modes there are, as bits.
    int standard = 0;
    int current = 0;
  };
  enum ControlIndex : std::uint8_t { kExposureMode, kExposureTime, kBrightness, kGain, kControlCount };

  [[nodiscard]] std::optional<Bytes> standard_answer(const UsbSetup& setup) const;
  [[nodiscard]] std::optional<Bytes> streaming_answer(const UsbSetup& setup, std::span<const std::uint8_t> sent);
  [[nodiscard]] std::optional<Bytes> control_answer(const UsbSetup& setup, std::span<const std::uint8_t> sent);
  static void complete(Probe& probe);

  std::string product_;
  std::string serial_;
  mutable std::mutex mutex_;
  Probe probe_{};
  std::optional<Probe> committed_;
  int generation_ = 0;
  std::array<Control, kControlCount> controls_{};
};

}  // namespace kinetrace::hal::test

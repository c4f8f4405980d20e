// State of each received device: the rows of `kinetrace monitor`.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "kinetrace/core/frame_result.hpp"
#include "kinetrace/core/health.hpp"
#include "kinetrace/core/stereo_geometry.hpp"
#include "kinetrace/publishing/result_reader.hpp"

namespace kinetrace::app {

/// Messages a second over the last two seconds.
class RateWindow {
 public:
  void add(std::int64_t now_ns) noexcept;
  /// 0 below two messages.
  [[nodiscard]] double rate_hz(std::int64_t now_ns) const noexcept;

 private:
  static constexpr std::int64_t kWindow_ns = 2'000'000'000;
  std::array<std::int64_t, 128> times_{};  ///< Ring of the newest arrival times.
  std::size_t count_ = 0;
};

struct MonitoredObject {
  ObjectResult result;
  double age_s = 0.0;  ///< Since the first observation, by the source's clock.
};

struct MonitoredReason {
  std::string name;
  std::uint64_t count = 0;
};

struct MonitoredDevice {
  std::string name;
  // Of the newest frame.
  std::int64_t frame_index = -1;
  std::int64_t timestamp_ns = 0;
  CameraResult camera;
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();
  double delay_ms = 0.0;  ///< From the sender's pipeline to here; valid only if both share a clock.
  std::vector<MonitoredObject> objects;
  std::optional<HealthState> health;
  std::string camera_state;
  std::vector<MonitoredReason> reasons;
  std::optional<StereoGeometry> calibration;
  RigEstimate rig;
  RateWindow poses;
  RateWindow object_frames;
};

/// Keeps at most kMaxDevices devices and, for the ages, kMaxIds objects of each; the oldest are forgotten.
class MonitorState final : public publishing::ResultListener {
 public:
  static constexpr std::size_t kMaxDevices = 16;
  static constexpr std::size_t kMaxIds = 1024;

  /// `device` empty: all.
  explicit MonitorState(std::string device) : wanted_(std::move(device)) {}

  /// Sets the clocks for the messages that follow.
  void set_time(std::int64_t steady_ns, std::int64_t system_ns) noexcept;

  void receive(const publishing::ReceivedCamera& camera) override;
  void receive(const publishing::ReceivedObjects& objects) override;
  void receive(const publishing::ReceivedHealth& health) override;
  void receive(const publishing::ReceivedCalibration& calibration) override;

  [[nodiscard]] bool wants(std::string_view device) const noexcept { return wanted_.empty() || wanted_ == device; }
  /// In the order of first reception.
  [[nodiscard]] const std::vector<MonitoredDevice>& devices() const noexcept { return devices_; }
  /// A received device that is not selected; empty: none.
  [[nodiscard]] const std::string& other_device() const noexcept { return other_; }
  /// Messages of selected devices, of any topic.
  [[nodiscard]] std::uint64_t messages() const noexcept { return messages_; }

 private:
  struct FirstSeen {
    std::uint32_t track_id = 0;
    std::int64_t timestamp_ns = 0;
  };
  struct Memory {
    std::vector<FirstSeen> first_seen;  ///< A ring once full; parallel to `devices_`.
    std::size_t oldest = 0;
    std::int64_t pieces_of = -1;  ///< Frame whose pieces are being assembled.
    std::uint32_t pieces_received = 0;
    std::vector<MonitoredObject> pieces;
  };
  /// Index in `devices_`; none for devices not selected or beyond the capacity.
  [[nodiscard]] std::optional<std::size_t> index_of(std::string_view device);
  [[nodiscard]] static double age_s(Memory& memory, std::uint32_t track_id, std::int64_t timestamp_ns);

  std::string wanted_;
  std::string other_;
  std::vector<MonitoredDevice> devices_;
  std::vector<Memory> memories_;
  std::int64_t steady_ns_ = 0;
  std::int64_t system_ns_ = 0;
  std::uint64_t messages_ = 0;
};

}  // namespace kinetrace::app

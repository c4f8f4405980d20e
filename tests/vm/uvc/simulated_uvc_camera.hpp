// A USB camera in software: the kernel's USB and UVC drivers talk to it over the USB/IP protocol, through a
// socket given to the virtual host controller (vhci-hcd). For the guest of tests/vm.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "frame_mark.hpp"
#include "usbip.hpp"
#include "uvc_function.hpp"

namespace kinetrace::hal::test {

/// Its frames carry a FrameMark with the index of their period, counted from one moment for all cameras of the process:
/// frames taken at the same time have the same index, whatever happens in transit. Modes wider than two marks show both
/// cameras side by side. A frame without room at the host is lost, so that a frame is never late by more than part of
/// a period.
class SimulatedUvcCamera {
 public:
  /// `camera`: 0 or 1; also the port it is plugged into.
  explicit SimulatedUvcCamera(int view);
  SimulatedUvcCamera(const SimulatedUvcCamera&) = delete;
  SimulatedUvcCamera& operator=(const SimulatedUvcCamera&) = delete;
  ~SimulatedUvcCamera();

  /// Returns when the kernel has taken notice; its drivers take a moment more. Throws std::runtime_error.
  void plug();
  /// Unplugs without notice, like a pulled cable.
  void unplug();

  /// Shows these pictures instead of marks, each of the mode's size, for `frames_each` frames, in the same frames on
  /// all cameras. Call before streaming.
  void show(std::vector<Bytes> pictures, int frames_each) {
    pictures_ = std::move(pictures);
    frames_each_ = frames_each;
  }
  void set_stalled(bool stalled) { stalled_ = stalled; }  ///< No frames, but requests are answered.
  void drop_frames(int count) { drop_ = count; }          ///< The sensor loses them.
  void cut_frames(int count) { cut_ = count; }            ///< They arrive by half.

  [[nodiscard]] std::string serial() const;
  [[nodiscard]] std::string bus_id() const;

 private:
  struct Transfer {
    std::uint32_t sequence = 0;
    std::uint32_t room = 0;
  };

  void answer_requests();
  void note_submission(const UsbipRequest& request);
  void queue(const UsbipRequest& request);
  void unlink(const UsbipRequest& request);
  void stream_frames();
  [[nodiscard]] Bytes make_payload(const UvcFunction::Streaming& streaming, std::uint32_t index);
  void send_payload(const Bytes& payload, const UvcFunction::Streaming& streaming);
  /// Waits for the host to ask for data; false when unplugged.
  [[nodiscard]] bool wait_for_transfer();

  int view_;
  std::vector<Bytes> pictures_;
  int frames_each_ = 1;
  UvcFunction function_;
  std::unique_ptr<UsbipConnection> connection_;
  std::thread answering_;
  std::thread streaming_;
  std::mutex mutex_;     ///< Guards the members below.
  std::mutex replying_;  ///< Held from taking a transfer to replying to it, and while unlinking one.
  std::condition_variable changed_;
  std::deque<Transfer> transfers_;
  std::uint32_t last_submitted_ = 0;         ///< Sequence of the newest request but unlinks.
  std::vector<UsbipRequest> early_unlinks_;  ///< Overtook the transfer that they name.
  bool plugged_ = false;
  bool frame_id_ = false;  ///< Alternates from frame to frame.
  std::atomic<bool> stalled_{false};
  std::atomic<int> drop_{0};
  std::atomic<int> cut_{0};
};

}  // namespace kinetrace::hal::test

// A camera whose frames and failures are given one by one.
#pragma once

#include <deque>
#include <thread>
#include <vector>

#include "kinetrace/hal/stereo_camera.hpp"

namespace kinetrace::hal::test {

/// Textured images, so that a flat part stands out. Ends with kEndOfStream. Like every camera it reports
/// nothing while it is closed.
class ScriptedCamera final : public StereoCamera {
 public:
  static constexpr int kWidth = 64;
  static constexpr int kHeight = 48;
  static constexpr std::int64_t kPeriod_ns = 100'000'000;

  ScriptedCamera() {
    for (int i = 0; i < kWidth * kHeight; ++i) {
      pixels_.push_back(static_cast<std::uint8_t>(i * 37 % 251));
    }
  }

  /// Frame `index` at its nominal time.
  [[nodiscard]] StereoFrame frame(std::int64_t index) const {
    const GrayView image{pixels_.data(), kWidth, kHeight, kWidth};
    return {index, index * kPeriod_ns, {}, image, image};
  }
  void give(const Result<StereoFrame>& result) { script_.push_back(result); }
  void give_frames(std::int64_t first, std::int64_t last) {
    for (std::int64_t i = first; i <= last; ++i) {
      give(frame(i));
    }
  }

  Status open() override { return move_to(CameraState::kConfigured); }
  Status start() override { return move_to(CameraState::kStreaming); }
  Status stop() override { return move_to(CameraState::kConfigured); }
  Status recover() override { return move_to(CameraState::kRecovering); }
  void close() noexcept override { state_ = CameraState::kClosed; }
  Result<StereoFrame> next(std::chrono::milliseconds timeout) override {
    if (state_ == CameraState::kClosed || state_ == CameraState::kConfigured) {
      return fail(ErrorCode::kIllegalState, "not streaming");
    }
    std::this_thread::sleep_for(std::min(timeout, frame_takes));
    if (timeout < frame_takes) {
      return fail(ErrorCode::kTimeout, "not yet");
    }
    if (script_.empty()) {
      return fail(ErrorCode::kEndOfStream, "end");
    }
    Result<StereoFrame> result = script_.front();
    script_.pop_front();
    counters_.frames_delivered += result ? 1 : 0;
    return result;
  }
  CameraState state() const noexcept override { return state_; }
  const CameraInfo& info() const noexcept override { return info_; }
  const CameraCounters& counters() const noexcept override { return counters_; }

  std::chrono::milliseconds frame_takes{0};

 private:
  Status move_to(CameraState state) {
    state_ = state;
    return {};
  }

  std::vector<std::uint8_t> pixels_;
  std::deque<Result<StereoFrame>> script_;
  CameraState state_ = CameraState::kClosed;
  CameraInfo info_{.name = "scripted",
                   .width_px = kWidth,
                   .height_px = kHeight,
                   .nominal_rate_hz = 1e9 / kPeriod_ns,
                   .frame_count = std::nullopt};
  CameraCounters counters_;
};

}  // namespace kinetrace::hal::test

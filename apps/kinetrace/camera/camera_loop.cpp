#include "camera/camera_loop.hpp"

#include <chrono>
#include <thread>

#include "cli/interrupt.hpp"
#include "cli/messages.hpp"

namespace kinetrace::app {
namespace {

using Clock = std::chrono::steady_clock;

// Bounds the delay until a signal is noticed while the camera is silent.
constexpr std::chrono::milliseconds kFrameTimeout(200);
constexpr std::chrono::milliseconds kBetweenRecoveries(20);

class Player {
 public:
  Player(const CameraLoop& loop, const std::function<Status(const StereoFrame&)>& visit) : loop_(loop), visit_(visit) {}

  Status play() {
    while (!is_over()) {
      const Result<StereoFrame> frame = next();
      loop_.health.observe(loop_.camera.state(), loop_.camera.counters());
      if (!frame && frame.error().code == ErrorCode::kEndOfStream) {
        break;
      }
      if (!frame) {
        on_idle();
      }
      if (Status handled = frame ? visit_(*frame) : handle_error(frame.error()); !handled) {
        return handled;
      }
      frames_ += frame ? 1 : 0;
    }
    return check_any_frame();
  }

 private:
  [[nodiscard]] bool is_over() const {
    const double seconds = std::chrono::duration<double>(Clock::now() - start_).count();
    return interrupted_by() != 0 || (loop_.until.max_frames > 0 && frames_ >= loop_.until.max_frames) ||
           (loop_.until.max_seconds > 0.0 && seconds >= loop_.until.max_seconds);
  }

  Result<StereoFrame> next() {
    const StageScope scope(loop_.observer, Stage::kCapture);
    return loop_.camera.next(kFrameTimeout);
  }

  void on_idle() const {
    if (loop_.on_idle) {
      loop_.on_idle();
    }
  }

  // A time-out is no error; nor is a loss that is waited for.
  Status handle_error(const Error& error) {
    if (error.code == ErrorCode::kTimeout) {
      return {};
    }
    if (error.code == ErrorCode::kDisconnected && loop_.waits_for_camera) {
      wait_for_camera(error);
      return {};
    }
    return Unexpected(error);
  }

  void wait_for_camera(const Error& loss) {
    loop_.progress.clear();
    print_warning(loss.message + "; waiting for it");
    while (!is_over()) {
      const bool is_back = loop_.camera.recover().has_value();
      loop_.health.observe(loop_.camera.state(), loop_.camera.counters());
      on_idle();
      if (is_back) {
        print_warning(loop_.camera.info().name + ": is back");
        return;
      }
      std::this_thread::sleep_for(kBetweenRecoveries);
    }
  }

  [[nodiscard]] Status check_any_frame() const {
    if (frames_ > 0 || interrupted_by() != 0) {
      return {};
    }
    return fail(ErrorCode::kTimeout,
                loop_.camera.info().name + ": not a single frame came; `kinetrace doctor` looks for the reason");
  }

  const CameraLoop& loop_;
  const std::function<Status(const StereoFrame&)>& visit_;
  Clock::time_point start_ = Clock::now();
  std::int64_t frames_ = 0;
};

}  // namespace

Status play_camera(const CameraLoop& loop, const std::function<Status(const StereoFrame&)>& visit) {
  return Player(loop, visit).play();
}

}  // namespace kinetrace::app

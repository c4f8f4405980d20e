#include "capture/capture_environment.hpp"

#include <algorithm>
#include <array>
#include <ctime>
#include <poll.h>

namespace kinetrace::hal {
namespace {

class Machine final : public CaptureEnvironment {
 public:
  Result<std::unique_ptr<CaptureDevice>> make_device(const CaptureConfig& config) override {
    return make_capture_device(config);
  }

  std::int64_t now_ns() override {
    timespec now{};
    clock_gettime(CLOCK_MONOTONIC, &now);
    return static_cast<std::int64_t>(now.tv_sec) * 1'000'000'000 + now.tv_nsec;
  }

  void wait(std::span<WaitHandle> handles, std::int64_t until_ns) override {
    constexpr std::int64_t kNanosecondsPerMs = 1'000'000;
    constexpr std::int64_t kMax_ms = 60'000;
    std::array<pollfd, 2> files{};
    const std::size_t count = std::min(handles.size(), files.size());
    for (std::size_t i = 0; i < count; ++i) {
      files[i] = {handles[i].fd, POLLIN, 0};
    }
    // Rounded up: waking just before the time would cause a second, useless wait.
    const std::int64_t left_ms = (until_ns - now_ns() + kNanosecondsPerMs - 1) / kNanosecondsPerMs;
    poll(files.data(), count, static_cast<int>(std::clamp<std::int64_t>(left_ms, 0, kMax_ms)));
    for (std::size_t i = 0; i < count; ++i) {
      handles[i].ready = files[i].revents != 0;
    }
  }
};

}  // namespace

CaptureEnvironment& machine_environment() {
  static Machine machine;
  return machine;
}

}  // namespace kinetrace::hal

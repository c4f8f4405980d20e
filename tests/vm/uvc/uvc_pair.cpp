#include "uvc_pair.hpp"

#include <algorithm>
#include <stdexcept>
#include <thread>
#include <vector>

#include "capture/capture_device.hpp"

namespace kinetrace::hal::test {
namespace {

std::vector<CaptureListing> listings(CaptureBackend backend) {
  std::vector<CaptureListing> all = list_capture_devices();
  std::erase_if(all, [backend](const CaptureListing& listing) { return listing.backend != backend; });
  return all;
}

}  // namespace

UvcPair::UvcPair() {
  left.plug();
  right.plug();
}

UvcPair& UvcPair::instance() {
  // Never destroyed: the machine is switched off with the program.
  static UvcPair* const pair = new UvcPair();
  return *pair;
}

void UvcPair::wait_until_listed(CaptureBackend backend, std::size_t count) {
  constexpr int kAttempts = 300;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    if (listings(backend).size() == count) {
      return;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  throw std::runtime_error("the guest has " + std::to_string(listings(backend).size()) + " cameras of " +
                           std::string(to_string(backend)) + ", not " + std::to_string(count));
}

CaptureConfig UvcPair::config(CaptureBackend backend, int view, PixelFormat format) const {
  const std::string name = view == 0 ? "Simulated Stereo Left" : "Simulated Stereo Right";
  CaptureConfig config;
  config.backend = backend;
  for (const CaptureListing& listing : listings(backend)) {
    if (listing.name.starts_with(name)) {
      config.device = listing.stable_id;
    }
  }
  config.format = format;
  config.width_px = 320;
  config.height_px = 240;
  config.rate_hz = 5.0;
  return config;
}

}  // namespace kinetrace::hal::test

#include "dds/monitor_state.hpp"

#include <algorithm>

namespace kinetrace::app {
namespace {

/// In double: received times are untrusted, and their difference may overflow 64 bits. Exact to a microsecond.
double difference_ns(std::int64_t later_ns, std::int64_t earlier_ns) noexcept {
  return static_cast<double>(later_ns) - static_cast<double>(earlier_ns);
}

}  // namespace

void RateWindow::add(std::int64_t now_ns) noexcept {
  times_[count_ % times_.size()] = now_ns;
  ++count_;
}

double RateWindow::rate_hz(std::int64_t now_ns) const noexcept {
  std::int64_t first_ns = now_ns;
  std::int64_t last_ns = now_ns - kWindow_ns;
  int received = 0;
  for (std::size_t i = 0; i < std::min(count_, times_.size()); ++i) {
    if (now_ns - times_[i] <= kWindow_ns) {
      first_ns = std::min(first_ns, times_[i]);
      last_ns = std::max(last_ns, times_[i]);
      ++received;
    }
  }
  return received < 2 || last_ns <= first_ns ? 0.0 : (received - 1) * 1e9 / static_cast<double>(last_ns - first_ns);
}

void MonitorState::set_time(std::int64_t steady_ns, std::int64_t system_ns) noexcept {
  steady_ns_ = steady_ns;
  system_ns_ = system_ns;
}

std::optional<std::size_t> MonitorState::index_of(std::string_view device) {
  if (!wants(device)) {
    other_ = device;
    return std::nullopt;
  }
  ++messages_;
  const auto known =
      std::find_if(devices_.begin(), devices_.end(), [&](const MonitoredDevice& d) { return d.name == device; });
  if (known != devices_.end()) {
    return static_cast<std::size_t>(known - devices_.begin());
  }
  if (devices_.size() == kMaxDevices) {
    return std::nullopt;
  }
  devices_.emplace_back();
  devices_.back().name = device;
  memories_.emplace_back();
  return devices_.size() - 1;
}

void MonitorState::receive(const publishing::ReceivedCamera& camera) {
  const std::optional<std::size_t> index = index_of(camera.device);
  if (!index) {
    return;
  }
  MonitoredDevice& device = devices_[*index];
  device.frame_index = camera.frame_index;
  device.timestamp_ns = camera.timestamp_ns;
  device.camera = camera.camera;
  device.velocity_mps = camera.velocity_mps;
  device.delay_ms = difference_ns(system_ns_, camera.handed_over_ns) * 1e-6;
  device.poses.add(steady_ns_);
}

double MonitorState::age_s(Memory& memory, std::uint32_t track_id, std::int64_t timestamp_ns) {
  const auto known = std::find_if(memory.first_seen.begin(), memory.first_seen.end(),
                                  [&](const FirstSeen& seen) { return seen.track_id == track_id; });
  if (known != memory.first_seen.end()) {
    return difference_ns(timestamp_ns, known->timestamp_ns) * 1e-9;
  }
  if (memory.first_seen.size() < kMaxIds) {
    memory.first_seen.push_back({track_id, timestamp_ns});
  } else {
    memory.first_seen[memory.oldest++ % kMaxIds] = {track_id, timestamp_ns};
  }
  return 0.0;
}

void MonitorState::receive(const publishing::ReceivedObjects& objects) {
  const std::optional<std::size_t> index = index_of(objects.device);
  if (!index) {
    return;
  }
  Memory& memory = memories_[*index];
  if (memory.pieces_of != objects.frame_index || objects.piece == 0) {
    memory.pieces_of = objects.frame_index;
    memory.pieces_received = 0;
    memory.pieces.clear();
  }
  for (const ObjectResult& object : objects.objects) {
    if (memory.pieces.size() == kMaxIds) {
      break;  // Beyond any valid sender.
    }
    memory.pieces.push_back({object, age_s(memory, object.track_id, objects.timestamp_ns)});
  }
  if (++memory.pieces_received == objects.pieces) {
    std::sort(memory.pieces.begin(), memory.pieces.end(),
              [](const MonitoredObject& a, const MonitoredObject& b) { return a.result.track_id < b.result.track_id; });
    devices_[*index].objects = memory.pieces;
    devices_[*index].object_frames.add(steady_ns_);
  }
}

void MonitorState::receive(const publishing::ReceivedHealth& health) {
  const std::optional<std::size_t> index = index_of(health.device);
  if (!index) {
    return;
  }
  MonitoredDevice& device = devices_[*index];
  device.health = health.state;
  device.camera_state = health.camera;
  device.rig = health.rig;
  device.reasons.clear();
  for (const publishing::ReceivedReason& reason : health.reasons) {
    device.reasons.push_back({std::string(reason.name), reason.count});
  }
}

void MonitorState::receive(const publishing::ReceivedCalibration& calibration) {
  if (const std::optional<std::size_t> index = index_of(calibration.device)) {
    devices_[*index].calibration = calibration.geometry;
  }
}

}  // namespace kinetrace::app

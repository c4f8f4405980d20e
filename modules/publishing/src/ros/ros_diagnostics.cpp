#include "ros/ros_diagnostics.hpp"

#include <cstdio>

#include "ros/ros_values.hpp"
#include "transport/sequences.hpp"

namespace kinetrace::publishing {
namespace {

// diagnostic_msgs/DiagnosticStatus.
std::uint8_t level(HealthState state) noexcept {
  constexpr std::uint8_t kOk = 0;
  constexpr std::uint8_t kWarn = 1;
  constexpr std::uint8_t kError = 2;
  return state == HealthState::kOk ? kOk : state == HealthState::kDegraded ? kWarn : kError;
}

}  // namespace

RosDiagnostics::RosDiagnostics(Arena& arena) : storage_(arena.take<Storage>(1).data()) {}

void RosDiagnostics::add(std::string_view key, std::uint64_t value) noexcept {
  std::snprintf(storage_->texts[count_].data(), storage_->texts[count_].size(), "%llu",
                static_cast<unsigned long long>(value));
  // Names are literals: zero-terminated and static.
  storage_->values[count_] = {ros_text(key.data()), storage_->texts[count_].data()};
  ++count_;
}

void RosDiagnostics::add(std::string_view key, std::string_view value) noexcept {
  std::array<char, 24>& text = storage_->texts[count_];
  copy_text(value, text);
  storage_->values[count_] = {ros_text(key.data()), text.data()};
  ++count_;
}

diagnostic_msgs_msg_dds__DiagnosticArray_ RosDiagnostics::fill(const PublishedHealth& health,
                                                               const PublishCounters& sent, const std::string& device,
                                                               const std_msgs_msg_dds__Header_& header) noexcept {
  count_ = 0;
  add("camera", health.camera);
  for (const HealthEntry& entry : health.entries) {
    if (entry.count > 0) {
      add(to_string(entry.reason), entry.count);
    }
  }
  for (const auto& [name, member] : kFrameCounterNames) {
    add(name, health.counters.*member);
  }
  for (const auto& [name, member] : kPublishCounterNames) {
    add(name, sent.*member);
  }
  diagnostic_msgs_msg_dds__DiagnosticStatus_& status = storage_->status;
  status.level = level(health.state);
  status.name = ros_text("kinetrace");
  status.message = ros_text(to_string(health.state).data());
  status.hardware_id = ros_text(device);
  set_items(status.values, std::span(storage_->values).first(count_));
  diagnostic_msgs_msg_dds__DiagnosticArray_ message{};
  message.header = header;
  set_items(message.status, {&status, 1});
  return message;
}

}  // namespace kinetrace::publishing

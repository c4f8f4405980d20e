// Output of `kinetrace monitor`.
#pragma once

#include <cstdint>
#include <string>

#include "dds/monitor_state.hpp"
#include "kinetrace/publishing/result_reader.hpp"

namespace kinetrace::app {

/// The table: a few lines of each device and one of each object.
[[nodiscard]] std::string monitor_table(const MonitorState& state, std::int64_t steady_ns);

/// Prints each message of a selected device as one line of JSON on standard output, then forwards it.
class JsonPrinter final : public publishing::ResultListener {
 public:
  /// Stops printing after `max_messages`; 0: never. `state` must outlive it.
  JsonPrinter(MonitorState& state, std::uint64_t max_messages) : state_(state), max_messages_(max_messages) {}
  void receive(const publishing::ReceivedCamera& camera) override;
  void receive(const publishing::ReceivedObjects& objects) override;
  void receive(const publishing::ReceivedHealth& health) override;
  void receive(const publishing::ReceivedCalibration& calibration) override;

 private:
  /// Forwards the message; true if it is to be printed.
  template <typename Received>
  [[nodiscard]] bool pass_on(const Received& received) {
    state_.receive(received);
    return state_.wants(received.device) && (max_messages_ == 0 || state_.messages() <= max_messages_);
  }

  MonitorState& state_;
  std::uint64_t max_messages_;
};

/// One line of JSON with the rates of a device.
[[nodiscard]] std::string rates_json(const MonitoredDevice& device, std::int64_t steady_ns);

}  // namespace kinetrace::app

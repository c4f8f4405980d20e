// Untrusted results over DDS, as `kinetrace monitor` receives and prints them: any order, any numbers, any text.
#include <string>

#include "dds/monitor_output.hpp"
#include "dds/monitor_state.hpp"
#include "dds_sample.hpp"
#include "fuzz_target.hpp"
#include "native/native_samples.hpp"

namespace {

using namespace kinetrace;
using namespace kinetrace::fuzz;

void tell_objects(FuzzedDataProvider& values, publishing::ResultListener& listener) {
  auto message = any_message<kinetrace_TrackedObjects>(values);
  end_text(message.device);
  std::vector<kinetrace_TrackedObject> objects;
  const auto count = values.ConsumeIntegralInRange<std::size_t>(0, 64);
  while (objects.size() < count && values.remaining_bytes() > 0) {
    auto object = any_message<kinetrace_TrackedObject>(values);
    object.moving = values.ConsumeBool();
    object.heading_known = values.ConsumeBool();
    objects.push_back(object);
  }
  show(message.objects, objects);
  publishing::tell(message, listener);
}

void tell_health(FuzzedDataProvider& values, publishing::ResultListener& listener) {
  auto message = any_message<kinetrace_Health>(values);
  end_text(message.device);
  end_text(message.camera);
  std::vector<kinetrace_HealthReason> reasons;
  std::vector<kinetrace_Counter> counters;
  const auto count = values.ConsumeIntegralInRange<std::size_t>(0, 32);
  while (reasons.size() < count && values.remaining_bytes() > 0) {
    end_text(reasons.emplace_back(any_message<kinetrace_HealthReason>(values)).name);
    end_text(counters.emplace_back(any_message<kinetrace_Counter>(values)).name);
  }
  show(message.reasons, reasons);
  show(message.counters, counters);
  publishing::tell(message, listener);
}

template <typename Message>
void tell_plain(FuzzedDataProvider& values, publishing::ResultListener& listener) {
  auto message = any_message<Message>(values);
  end_text(message.device);
  publishing::tell(message, listener);
}

}  // namespace

void kinetrace::fuzz::try_input(std::string_view input) {
  FuzzedDataProvider values(reinterpret_cast<const std::uint8_t*>(input.data()), input.size());
  app::MonitorState state("");
  app::JsonPrinter printer(state, 0);
  std::int64_t now_ns = 1'700'000'000'000'000'000;
  while (values.remaining_bytes() > 0) {
    now_ns += values.ConsumeIntegral<std::uint32_t>();
    state.set_time(now_ns, now_ns);
    switch (values.ConsumeIntegralInRange(0, 3)) {
      case 0: tell_objects(values, printer); break;
      case 1: tell_health(values, printer); break;
      case 2: tell_plain<kinetrace_CameraPose>(values, printer); break;
      default: tell_plain<kinetrace_Calibration>(values, printer); break;
    }
  }
  require(state.devices().size() <= app::MonitorState::kMaxDevices);
  const std::string table = app::monitor_table(state, now_ns);
  require(table.find('\x1b') == std::string::npos);
  for (const app::MonitoredDevice& device : state.devices()) {
    static_cast<void>(app::rates_json(device, now_ns));
  }
}

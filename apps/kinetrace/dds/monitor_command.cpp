#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <optional>
#include <string>
#include <unistd.h>

#include "cli/interrupt.hpp"
#include "cli/messages.hpp"
#include "dds/dds_command_line.hpp"
#include "dds/dds_link.hpp"
#include "dds/monitor_output.hpp"
#include "kinetrace/publishing/ros_reader.hpp"
#include "kinetrace/recording/mcap_writer.hpp"

namespace kinetrace::app {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;

/// Records ROS 2 topics to an MCAP file.
class McapRecording {
 public:
  McapRecording(publishing::Link& link, const std::string& prefix, recording::McapWriter file)
      : reader_(link, prefix), file_(std::move(file)) {}

  /// Errors: kIo.
  [[nodiscard]] static Result<std::unique_ptr<McapRecording>> create(publishing::Link& link, const std::string& prefix,
                                                                     const std::filesystem::path& path) {
    Result<recording::McapWriter> file = recording::McapWriter::create(path, "kinetrace " KINETRACE_VERSION);
    if (!file) {
      return Unexpected(file.error());
    }
    auto made = std::make_unique<McapRecording>(link, prefix, std::move(*file));
    for (const publishing::RosTopicDescription& topic : made->reader_.topics()) {
      const Result<std::uint16_t> channel =
          made->file_.add_topic({topic.name, topic.type, topic.definition, {{"offered_qos_profiles", topic.qos}}});
      if (!channel) {
        return Unexpected(channel.error());
      }
      made->channels_.push_back(*channel);
    }
    return made;
  }

  [[nodiscard]] Status take() {
    return reader_.take([this](const publishing::RosMessage& message) {
      return file_.write(channels_[message.topic], system_time_ns(), message.sent_ns, message.cdr);
    });
  }
  [[nodiscard]] Status finish() { return file_.finish(); }
  [[nodiscard]] recording::McapCounters counters() const noexcept { return file_.counters(); }

 private:
  publishing::RosReader reader_;
  recording::McapWriter file_;
  std::vector<std::uint16_t> channels_;
};

/// Redraws the table on a terminal; elsewhere prints it once a second. With JSON, only the rates.
class Display {
 public:
  Display(bool json, bool quiet) : json_(json), quiet_(quiet), redraws_(!json && is_terminal()) {}

  /// Rate-limited, except for `is_last`.
  void show(const MonitorState& state, std::int64_t now_ns, bool is_last = false) {
    if (quiet_ || (now_ns < next_ns_ && !is_last) || state.devices().empty()) {
      return;
    }
    next_ns_ = now_ns + (redraws_ ? kSecond_ns / 5 : kSecond_ns);
    std::string text;
    if (json_) {
      for (const MonitoredDevice& device : state.devices()) {
        text += rates_json(device, now_ns);
      }
    } else {
      constexpr const char* kHomeAndClear = "\033[H\033[J";
      text = (redraws_ ? kHomeAndClear : "") + monitor_table(state, now_ns) + (redraws_ ? "" : "\n");
    }
    std::fwrite(text.data(), 1, text.size(), stdout);
    std::fflush(stdout);
  }

 private:
  static bool is_terminal() {
    const char* term = std::getenv("TERM");
    return isatty(STDOUT_FILENO) == 1 && term != nullptr && std::string_view(term) != "dumb";
  }

  bool json_;
  bool quiet_;
  bool redraws_;
  std::int64_t next_ns_ = 0;
};

std::string nothing_received(const publishing::PublishConfig& config, const MonitorState& state,
                             const std::string& wanted) {
  const std::string where = "domain " + std::to_string(config.domain) + " on " + config.interface;
  if (!state.other_device().empty()) {
    return "nothing seen device " + wanted + " in " + where + ", but of " + state.other_device() +
           "; choose it with --device, or leave --device out";
  }
  return "nothing received from Kinetrace in " + where +
         "; is `kinetrace run --publish` at work there, with the same dds.domain, a connected dds.interface and "
         "files of the same dds.security, and with dds.native?";
}

class Monitor {
 public:
  Monitor(const MonitorOptions& options, publishing::PublishConfig config, publishing::Link& link,
          std::unique_ptr<McapRecording> recording)
      : options_(options),
        config_(std::move(config)),
        link_(link),
        recording_(std::move(recording)),
        reader_(link),
        state_(options.network.device),
        printer_(state_, static_cast<std::uint64_t>(options.messages)),
        display_(options.json, options.quiet) {}

  Outcome<void> run() {
    begin_ns_ = steady_time_ns();
    Status received;
    while (received && !is_over()) {
      state_.set_time(steady_time_ns(), system_time_ns());
      received = take();
      display_.show(state_, steady_time_ns());
      warn_of_no_data();
      serve(link_);
    }
    display_.show(state_, steady_time_ns(), true);
    // Completes the MCAP file, also after an error.
    if (recording_) {
      const Status finished = recording_->finish();
      received = received ? finished : received;
      report_recording();
    }
    if (!received) {
      return failure(received.error());
    }
    if (is_silent()) {
      return Unexpected(Failure{ExitCode::kIo, nothing_received(config_, state_, options_.network.device)});
    }
    return {};
  }

 private:
  [[nodiscard]] Status take() {
    publishing::ResultListener& listener = options_.json ? static_cast<publishing::ResultListener&>(printer_) : state_;
    Status taken = reader_.take(listener);
    return taken && recording_ ? recording_->take() : taken;
  }
  [[nodiscard]] bool is_over() const {
    const double seconds = static_cast<double>(steady_time_ns() - begin_ns_) * 1e-9;
    // The reader of a pipe may have closed it.
    return interrupted_by() != 0 || std::ferror(stdout) != 0 ||
           (options_.seconds > 0.0 && seconds >= options_.seconds) ||
           (options_.messages > 0 && state_.messages() >= static_cast<std::uint64_t>(options_.messages));
  }
  [[nodiscard]] bool is_silent() const {
    return state_.messages() == 0 && (!recording_ || recording_->counters().messages == 0);
  }
  void warn_of_no_data() {
    constexpr std::int64_t kTimeout_ns = 3 * kSecond_ns;
    if (!has_warned_ && is_silent() && steady_time_ns() - begin_ns_ > kTimeout_ns) {
      has_warned_ = true;
      print_warning(nothing_received(config_, state_, options_.network.device) + " Listening on");
    }
  }
  void report_recording() const {
    if (!options_.quiet) {
      const recording::McapCounters counters = recording_->counters();
      std::fprintf(stderr, "%llu messages, %.1f MiB in %s\n", static_cast<unsigned long long>(counters.messages),
                   static_cast<double>(counters.bytes) / (1024.0 * 1024.0), options_.record.c_str());
    }
  }

  MonitorOptions options_;
  publishing::PublishConfig config_;
  publishing::Link& link_;
  std::unique_ptr<McapRecording> recording_;  ///< Null unless asked for.
  publishing::ResultReader reader_;
  MonitorState state_;
  JsonPrinter printer_;
  Display display_;
  std::int64_t begin_ns_ = 0;
  bool has_warned_ = false;
};

Outcome<void> monitor(const MonitorOptions& options) {
  Result<publishing::PublishConfig> config = network_config(options.network);
  if (!config) {
    return failure(config.error());
  }
  auto link = publishing::Link::create(*config);
  if (!link) {
    return failure(link.error());
  }
  std::unique_ptr<McapRecording> recording;
  if (!options.record.empty()) {
    auto made = McapRecording::create(**link, config->ros2.prefix, options.record);
    if (!made) {
      return Unexpected(Failure{ExitCode::kCannotCreate, made.error().message});
    }
    recording = std::move(*made);
  }
  catch_interrupts();
  return Monitor(options, std::move(*config), **link, std::move(recording)).run();
}

}  // namespace

int monitor_command(const MonitorOptions& options) {
  const Outcome<void> outcome = monitor(options);
  return outcome ? 0 : report(outcome.error());
}

}  // namespace kinetrace::app

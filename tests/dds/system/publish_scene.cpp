// Publishes a scene known to readers (scene.hpp), with the program's threads: one hands results over, another
// publishes. Writes its counters to standard output, as JSON lines.
//
//   publish_scene [--rate HZ] [--frames N] [--objects N] [--new-ids] [KEY=VALUE...]     keys as dds.interface
#include <atomic>
#include <charconv>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <iostream>
#include <string>
#include <sys/resource.h>
#include <thread>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "kinetrace/publishing/publisher.hpp"
#include "scene.hpp"

namespace kinetrace::test {
namespace {

using publishing::PublishConfig;
using Clock = std::chrono::steady_clock;

std::atomic<bool> is_over{false};

struct Options {
  double rate_hz = 50.0;
  std::int64_t frames = 0;  ///< 0: until a signal.
  Scene::Options scene;
  PublishConfig publishing;
};

bool assign(int& field, const std::string& text) {
  return std::from_chars(text.data(), text.data() + text.size(), field).ptr == text.data() + text.size();
}
bool assign(bool& field, const std::string& text) {
  field = text == "true";
  return field || text == "false";
}
bool assign(std::string& field, const std::string& text) {
  field = text;
  return true;
}
template <typename Enum>
bool assign(Enum& field, const std::string& text) {
  return from_string(text, field);
}

bool set(PublishConfig& config, const std::string& setting) {
  const std::size_t equals = setting.find('=');
  bool is_set = false;
  publishing::visit_fields(config, [&](std::string_view key, auto& field, std::string_view) {
    is_set = is_set || (equals != std::string::npos && key == setting.substr(0, equals) &&
                        assign(field, setting.substr(equals + 1)));
  });
  return is_set;
}

bool parse(const std::vector<std::string>& arguments, Options& options) {
  bool is_clean = true;
  for (std::size_t i = 0; i < arguments.size() && is_clean; ++i) {
    const std::string& name = arguments[i];
    const auto value = [&] { return i + 1 < arguments.size() ? arguments[++i] : std::string("0"); };
    if (name == "--rate") {
      options.rate_hz = std::stod(value());
    } else if (name == "--frames") {
      options.frames = std::stoll(value());
    } else if (name == "--objects") {
      options.scene.objects = std::stoul(value());
    } else if (name == "--new-ids") {
      options.scene.has_new_ids = true;
    } else {
      is_clean = set(options.publishing, name);
      std::cerr << (is_clean ? "" : "not understood: " + name + "\n");
    }
  }
  return is_clean;
}

/// Number of this thread's waits.
std::int64_t waits() {
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);
  return usage.ru_nvcsw;
}

void print(const Scene& scene, const publishing::ResultMailbox& mailbox, const publishing::Publisher& publisher,
           std::int64_t waited) {
  nlohmann::json line{{"state", to_string(publisher.state())},
                      {"ids", scene.ids()},
                      {"pipeline_waits", waited},
                      {"offered", mailbox.counters().offered},
                      {"superseded", mailbox.counters().superseded},
                      {"poses_dropped", mailbox.counters().trajectory_poses_dropped}};
  const publishing::PublishCounters counters = publisher.counters();
  for (const auto& [name, member] : publishing::kPublishCounterNames) {
    line[std::string(name)] = counters.*member;
  }
  std::cout << line.dump() << std::endl;
}

void serve(publishing::Publisher& publisher, publishing::ResultMailbox& mailbox) {
  constexpr auto kPause = std::chrono::milliseconds(1);
  while (!is_over) {
    publisher.serve(mailbox, Clock::now().time_since_epoch().count());
    while (const std::optional<std::string> notice = publisher.take_notice()) {
      std::cerr << *notice << std::endl;
    }
    std::this_thread::sleep_for(kPause);
  }
}

/// The pipeline's side: results at a steady rate, published or not.
void produce(const Options& options, publishing::ResultMailbox& mailbox, const publishing::Publisher& publisher) {
  const auto period = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(1.0 / options.rate_hz));
  constexpr auto kPrintEvery = std::chrono::milliseconds(100);
  Scene scene(options.scene);
  std::int64_t waited = 0;
  Clock::time_point next = Clock::now();
  Clock::time_point next_print = next;
  for (std::int64_t i = 0; !is_over && (options.frames == 0 || i < options.frames); ++i) {
    const FrameResult& result = scene.next();
    const std::int64_t waits_before = waits();
    mailbox.offer(result, result.newest.timestamp_ns);
    mailbox.offer_health(scene.health());
    waited += waits() - waits_before;
    if (Clock::now() >= next_print) {
      next_print = Clock::now() + kPrintEvery;
      print(scene, mailbox, publisher, waited);
    }
    std::this_thread::sleep_until(next += period);
  }
  print(scene, mailbox, publisher, waited);
}

int refuse(const Error& error) {
  std::cerr << "error: " << error.message << std::endl;
  constexpr int kRefused = 78;
  return kRefused;
}

int run(const Options& options) {
  const std::size_t bytes = publishing::ResultMailbox::required_bytes(options.publishing) +
                            publishing::Publisher::required_bytes(options.publishing);
  Arena arena(bytes);
  const auto mailbox = publishing::ResultMailbox::create(options.publishing, arena);
  if (!mailbox) {
    return refuse(mailbox.error());
  }
  const auto publisher = publishing::Publisher::create(options.publishing, Scene::geometry(), arena);
  if (!publisher) {
    return refuse(publisher.error());
  }
  std::thread server([&] { serve(**publisher, **mailbox); });
  produce(options, **mailbox, **publisher);
  is_over = true;
  server.join();
  return 0;
}

}  // namespace
}  // namespace kinetrace::test

int main(int argc, char** argv) {
  using namespace kinetrace::test;
  std::signal(SIGTERM, [](int) { is_over = true; });
  Options options;
  options.publishing.ros2.stamps = kinetrace::publishing::RosStamps::kSource;  // Readers know the times too.
  constexpr int kUsage = 64;
  return parse({argv + 1, argv + argc}, options) ? run(options) : kUsage;
}

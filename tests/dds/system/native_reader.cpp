// Reads Kinetrace's own topics on the loopback, and writes the numbers of samples and instances to standard output, as
// JSON lines.
#include <array>
#include <atomic>
#include <chrono>
#include <csignal>
#include <iostream>
#include <thread>
#include <vector>

#include <dds/dds.h>
#include <nlohmann/json.hpp>

#include "kinetrace.h"
#include "kinetrace/publishing/topics.hpp"

namespace kinetrace::test {
namespace {

namespace topics = publishing::topics;

std::atomic<bool> is_over{false};

constexpr const char* kLoopbackOnly =
    "<CycloneDDS><Domain Id=\"any\"><General><Interfaces><NetworkInterface name=\"lo\" "
    "multicast=\"false\"/></Interfaces>"
    "<AllowMulticast>false</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex>"
    "<MaxAutoParticipantIndex>31</MaxAutoParticipantIndex><Peers><Peer address=\"127.0.0.1\"/></Peers></Discovery>"
    "</Domain></CycloneDDS>";

struct Topic {
  const char* name;
  const dds_topic_descriptor_t* type;
  bool is_kept = false;  ///< By its writer, for late readers.
  std::uint64_t samples = 0;
  dds_entity_t reader = 0;
};

dds_entity_t make_reader(dds_entity_t participant, const Topic& topic) {
  dds_qos_t* qos = dds_create_qos();
  constexpr std::int32_t kDepth = 64;
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, kDepth);
  dds_qset_durability(qos, topic.is_kept ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
  const dds_entity_t entity = dds_create_topic(participant, topic.type, topic.name, nullptr, nullptr);
  const dds_entity_t reader = dds_create_reader(participant, entity, qos, nullptr);
  dds_delete_qos(qos);
  return reader;
}

void take_all(Topic& topic) {
  constexpr std::size_t kAtOnce = 64;
  std::array<void*, kAtOnce> loans{};
  std::array<dds_sample_info_t, kAtOnce> infos{};
  const dds_return_t count = dds_take(topic.reader, loans.data(), infos.data(), kAtOnce, kAtOnce);
  if (count > 0) {
    for (dds_return_t i = 0; i < count; ++i) {
      topic.samples += infos[static_cast<std::size_t>(i)].valid_data ? 1 : 0;
    }
    dds_return_loan(topic.reader, loans.data(), count);
  }
}

void print(const std::vector<Topic>& all) {
  nlohmann::json line;
  std::uint64_t total = 0;
  for (const Topic& topic : all) {
    line["samples"][topic.name] = topic.samples;
    total += topic.samples;
  }
  line["total"] = total;
  std::cout << line.dump() << std::endl;
}

int run() {
  const dds_entity_t domain = dds_create_domain(0, kLoopbackOnly);
  const dds_entity_t participant = dds_create_participant(0, nullptr, nullptr);
  if (domain < 0 || participant < 0) {
    std::cerr << "participant refused" << std::endl;
    return 1;
  }
  std::vector<Topic> all{{topics::kCameraPose, &kinetrace_CameraPose_desc},
                         {topics::kObjects, &kinetrace_TrackedObjects_desc},
                         {topics::kTrajectories, &kinetrace_TrajectoryPiece_desc},
                         {topics::kPoints, &kinetrace_PointPiece_desc},
                         {topics::kHealth, &kinetrace_Health_desc, true},
                         {topics::kCalibration, &kinetrace_Calibration_desc, true}};
  for (Topic& topic : all) {
    topic.reader = make_reader(participant, topic);
  }
  constexpr auto kPrintEvery = std::chrono::milliseconds(100);
  constexpr auto kPause = std::chrono::milliseconds(2);
  auto next_print = std::chrono::steady_clock::now();
  while (!is_over) {
    for (Topic& topic : all) {
      take_all(topic);
    }
    if (std::chrono::steady_clock::now() >= next_print) {
      next_print += kPrintEvery;
      print(all);
    }
    std::this_thread::sleep_for(kPause);
  }
  dds_delete(domain);
  return 0;
}

}  // namespace
}  // namespace kinetrace::test

int main() {  // NOLINT(bugprone-exception-escape): what is thrown ends a test as it should.
  std::signal(SIGTERM, [](int) { kinetrace::test::is_over = true; });
  return kinetrace::test::run();
}

// A reader in a separate process: reads every topic of a publisher on the loopback and counts the messages.
//
//   listener DOMAIN    prints "matched" once it will miss no further message; after SIGTERM, "TOPIC MESSAGES" for each.
#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <string>

#include <dds/dds.h>

#include "kinetrace.h"
#include "kinetrace/publishing/topics.hpp"
#include "ros2.h"

namespace {

namespace topics = kinetrace::publishing::topics;

// NOLINTNEXTLINE(cppcoreguidelines-avoid-non-const-global-variables): a signal handler has nothing else.
volatile std::sig_atomic_t ends = 0;

constexpr const char* kLoopback =
    "<CycloneDDS><Domain Id=\"any\"><General><Interfaces><NetworkInterface name=\"lo\" "
    "multicast=\"false\"/></Interfaces>"
    "<AllowMulticast>false</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex>"
    "<Peers><Peer address=\"127.0.0.1\"/></Peers></Discovery></Domain></CycloneDDS>";

struct Listened {
  const char* topic;
  const dds_topic_descriptor_t& type;
  dds_data_representation_id_t encoding;
  bool is_kept = false;  ///< Late readers get the last message.
  dds_entity_t reader = 0;
  long messages = 0;
};

dds_entity_t make_reader(dds_entity_t participant, const Listened& listened) {
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 100);
  dds_qset_durability(qos, listened.is_kept ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
  dds_qset_data_representation(qos, 1, &listened.encoding);
  const dds_entity_t topic = dds_create_topic(participant, &listened.type, listened.topic, nullptr, nullptr);
  const dds_entity_t reader = dds_create_reader(participant, topic, qos, nullptr);
  dds_delete_qos(qos);
  return reader;
}

bool knows_writer(const Listened& listened) {
  dds_subscription_matched_status_t status{};
  return dds_get_subscription_matched_status(listened.reader, &status) == DDS_RETCODE_OK && status.current_count > 0;
}

// A reader can know a writer that has not discovered it yet. The calibration is sent as soon as its writer has
// discovered the last reader, and readers are discovered in the order of their creation.
bool is_known_to_writers(const Listened& made_last) {
  return made_last.messages > 0;
}

void take_all(Listened& listened) {
  std::array<void*, 16> samples{};
  std::array<dds_sample_info_t, 16> infos{};
  dds_return_t taken = dds_take(listened.reader, samples.data(), infos.data(), samples.size(), samples.size());
  while (taken > 0) {
    for (dds_return_t i = 0; i < taken; ++i) {
      listened.messages += infos[static_cast<std::size_t>(i)].valid_data ? 1 : 0;
    }
    dds_return_loan(listened.reader, samples.data(), taken);
    taken = dds_take(listened.reader, samples.data(), infos.data(), samples.size(), samples.size());
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "listener DOMAIN\n");
    return 64;
  }
  std::signal(SIGTERM, [](int) { ends = 1; });
  const auto domain = static_cast<dds_domainid_t>(std::strtoul(argv[1], nullptr, 10));
  if (dds_create_domain(domain, kLoopback) < 0) {
    return 1;
  }
  const dds_entity_t participant = dds_create_participant(domain, nullptr, nullptr);
  constexpr dds_data_representation_id_t kNative = DDS_DATA_REPRESENTATION_XCDR2;
  constexpr dds_data_representation_id_t kRos = DDS_DATA_REPRESENTATION_XCDR1;
  std::array<Listened, 10> all{{{topics::kCameraPose, kinetrace_CameraPose_desc, kNative},
                                {topics::kObjects, kinetrace_TrackedObjects_desc, kNative},
                                {topics::kTrajectories, kinetrace_TrajectoryPiece_desc, kNative},
                                {topics::kPoints, kinetrace_PointPiece_desc, kNative},
                                {"rt/kinetrace/odometry", nav_msgs_msg_dds__Odometry__desc, kRos},
                                {"rt/tf", tf2_msgs_msg_dds__TFMessage__desc, kRos},
                                {"rt/kinetrace/detections", vision_msgs_msg_dds__Detection3DArray__desc, kRos},
                                {"rt/kinetrace/markers", visualization_msgs_msg_dds__MarkerArray__desc, kRos},
                                {"rt/kinetrace/points", sensor_msgs_msg_dds__PointCloud2__desc, kRos},
                                {topics::kCalibration, kinetrace_Calibration_desc, kNative, true}}};
  for (Listened& listened : all) {
    listened.reader = make_reader(participant, listened);
  }
  bool said_matched = false;
  while (ends == 0) {
    for (Listened& listened : all) {
      take_all(listened);
    }
    if (!said_matched && std::all_of(all.begin(), all.end(), knows_writer) && is_known_to_writers(all.back())) {
      std::printf("matched\n");
      std::fflush(stdout);
      said_matched = true;
    }
    dds_sleepfor(DDS_MSECS(5));
  }
  for (const Listened& listened : all) {
    std::printf("%s %ld\n", listened.topic, listened.messages);
  }
  return 0;
}

// A satellite receiver on ROS 2, which uses only the message type of Kinetrace.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>

#include <dds/dds.h>

#include "ros2.h"

namespace kinetrace::test {

class ReceiverTopic {
 public:
  ReceiverTopic(int domain, const char* topic, bool reliable)
      : participant_(dds_create_participant(static_cast<dds_domainid_t>(domain), nullptr, nullptr)) {
    dds_qos_t* qos = dds_create_qos();
    dds_qset_reliability(qos, reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT, DDS_SECS(1));
    dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 10);
    const dds_data_representation_id_t encoding = DDS_DATA_REPRESENTATION_XCDR1;
    dds_qset_data_representation(qos, 1, &encoding);
    const dds_entity_t entity =
        dds_create_topic(participant_, &sensor_msgs_msg_dds__NavSatFix__desc, topic, nullptr, nullptr);
    writer_ = dds_create_writer(participant_, entity, qos, nullptr);
    dds_delete_qos(qos);
  }
  ReceiverTopic(const ReceiverTopic&) = delete;
  ReceiverTopic& operator=(const ReceiverTopic&) = delete;
  ~ReceiverTopic() { dds_delete(participant_); }

  [[nodiscard]] bool is_matched() const {
    dds_publication_matched_status_t status{};
    return dds_get_publication_matched_status(writer_, &status) == DDS_RETCODE_OK && status.current_count > 0;
  }

  /// `place`: latitude, longitude, altitude. The covariance has this variance on its diagonal, and 1 and 2 at (0, 1)
  /// and (1, 0).
  void send(std::int64_t stamp_ns, int status, const std::array<double, 3>& place, int covariance_type,
            double variance_m2) const {
    std::string frame = "gps";
    sensor_msgs_msg_dds__NavSatFix_ fix{};
    fix.header.stamp = {static_cast<std::int32_t>(stamp_ns / 1'000'000'000),
                        static_cast<std::uint32_t>(stamp_ns % 1'000'000'000)};
    fix.header.frame_id = frame.data();
    fix.status = {static_cast<std::int8_t>(status), 1};
    fix.latitude = place[0];
    fix.longitude = place[1];
    fix.altitude = place[2];
    const std::array<double, 9> covariance{variance_m2, 1.0, 0.0, 2.0, variance_m2, 0.0, 0.0, 0.0, variance_m2};
    std::copy(covariance.begin(), covariance.end(), fix.position_covariance);
    fix.position_covariance_type = static_cast<std::uint8_t>(covariance_type);
    dds_write(writer_, &fix);
  }

 private:
  dds_entity_t participant_;
  dds_entity_t writer_ = 0;
};

}  // namespace kinetrace::test

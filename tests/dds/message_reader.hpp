// A reader of one topic that shares only the message types with the publisher.
#pragma once

#include <chrono>
#include <string>

#include <dds/dds.h>

namespace kinetrace::test {

/// Reads in the domain of this process's publisher, or in one of its own. `T` is the message's C struct.
template <typename T>
class MessageReader {
 public:
  MessageReader(int domain, const dds_topic_descriptor_t& type, const std::string& topic,
                dds_data_representation_id_t encoding, bool gets_kept = false, int depth = 100)
      : participant_(dds_create_participant(static_cast<dds_domainid_t>(domain), nullptr, nullptr)) {
    dds_qos_t* qos = dds_create_qos();
    dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
    dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, depth);
    dds_qset_data_representation(qos, 1, &encoding);
    dds_qset_durability(qos, gets_kept ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
    const dds_entity_t entity = dds_create_topic(participant_, &type, topic.c_str(), nullptr, nullptr);
    reader_ = dds_create_reader(participant_, entity, qos, nullptr);
    dds_delete_qos(qos);
  }
  MessageReader(const MessageReader&) = delete;
  MessageReader& operator=(const MessageReader&) = delete;
  ~MessageReader() {
    give_back();
    dds_delete(participant_);
  }

  [[nodiscard]] bool is_matched() const {
    dds_subscription_matched_status_t status{};
    return dds_get_subscription_matched_status(reader_, &status) == DDS_RETCODE_OK && status.current_count > 0;
  }

  /// The next message in order; null if none came in time. Valid until the next call.
  [[nodiscard]] const T* next(std::chrono::milliseconds timeout = std::chrono::milliseconds(2000)) {
    give_back();
    const auto deadline = std::chrono::steady_clock::now() + timeout;
    do {
      dds_sample_info_t info{};
      sample_ = nullptr;
      if (dds_take(reader_, &sample_, &info, 1, 1) == 1 && info.valid_data) {
        return static_cast<const T*>(sample_);
      }
      give_back();
      dds_sleepfor(DDS_MSECS(1));
    } while (std::chrono::steady_clock::now() < deadline);
    return nullptr;
  }

 private:
  void give_back() {
    if (sample_ != nullptr) {
      dds_return_loan(reader_, &sample_, 1);
      sample_ = nullptr;
    }
  }

  dds_entity_t participant_;
  dds_entity_t reader_ = 0;
  void* sample_ = nullptr;
};

}  // namespace kinetrace::test

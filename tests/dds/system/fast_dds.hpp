// Fast DDS 2 (Debian 12) and Fast DDS 3 (Debian 13): what differs between them for a reader.
#pragma once

#include <fastdds/dds/domain/DomainParticipantListener.hpp>
#include <string>
#include <vector>

#if __has_include(<fastrtps/utils/IPLocator.h>)
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>

#include "ros_messagesPubSubTypes.h"
#else
#define KINETRACE_FAST_DDS_3
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.hpp>
#include <fastdds/utils/IPLocator.hpp>

#include "ros_messagesPubSubTypes.hpp"
#endif

namespace kinetrace::test {

namespace dds = eprosima::fastdds::dds;

/// A data writer of another participant.
struct DiscoveredWriter {
  std::string topic;
  std::string type;
  std::vector<dds::DataRepresentationId_t> encodings;
  bool reliable = false;
};

#ifdef KINETRACE_FAST_DDS_3

namespace rtps = eprosima::fastdds::rtps;
inline constexpr auto kOk = dds::RETCODE_OK;

/// Discovery data of other participants.
class DiscoveryListener : public dds::DomainParticipantListener {
 public:
  void on_data_writer_discovery(dds::DomainParticipant* /*participant*/, rtps::WriterDiscoveryStatus reason,
                                const dds::PublicationBuiltinTopicData& info, bool& /*is_ignored*/) final {
    if (reason == rtps::WriterDiscoveryStatus::DISCOVERED_WRITER) {
      on_writer({info.topic_name.to_string(), info.type_name.to_string(), info.representation.m_value,
                 info.reliability.kind == dds::RELIABLE_RELIABILITY_QOS});
    }
  }
  void on_participant_discovery(dds::DomainParticipant* /*participant*/, rtps::ParticipantDiscoveryStatus reason,
                                const dds::ParticipantBuiltinTopicData& /*info*/, bool& /*is_ignored*/) final {
    if (reason == rtps::ParticipantDiscoveryStatus::DISCOVERED_PARTICIPANT) {
      on_participant();
    }
  }

#else

namespace rtps = eprosima::fastrtps::rtps;
inline constexpr auto kOk = ReturnCode_t::RETCODE_OK;

/// Discovery data of other participants.
class DiscoveryListener : public dds::DomainParticipantListener {
 public:
  void on_publisher_discovery(dds::DomainParticipant* /*participant*/, rtps::WriterDiscoveryInfo&& info) final {
    if (info.status == rtps::WriterDiscoveryInfo::DISCOVERED_WRITER) {
      on_writer({info.info.topicName().to_string(), info.info.typeName().to_string(),
                 info.info.m_qos.representation.m_value,
                 info.info.m_qos.m_reliability.kind == dds::RELIABLE_RELIABILITY_QOS});
    }
  }
  void on_participant_discovery(dds::DomainParticipant* /*participant*/, rtps::ParticipantDiscoveryInfo&& info) final {
    if (info.status == rtps::ParticipantDiscoveryInfo::DISCOVERED_PARTICIPANT) {
      on_participant();
    }
  }

#endif

 protected:
  virtual void on_writer(const DiscoveredWriter& writer) = 0;
  virtual void on_participant() = 0;
};

}  // namespace kinetrace::test

#include "transport/topic_reader.hpp"

namespace kinetrace::publishing {

Result<TopicReader> TopicReader::create(const Link& link, const LinkMembership& membership,
                                        const dds_topic_descriptor_t& type, const std::string& topic,
                                        const TopicQos& qos) {
  const ForeignCall foreign;
  const Qos settings = make_qos(qos);
  TopicReader made;
  made.topic_ = Entity(dds_create_topic(membership.participant, &type, topic.c_str(), nullptr, nullptr));
  if (!made.topic_.exists()) {
    return fail(ErrorCode::kIo, "DDS topic " + topic + " cannot be made: " + made.topic_.error());
  }
  made.reader_ = Entity(dds_create_reader(membership.participant, made.topic_.get(), settings.get(), nullptr));
  if (!made.reader_.exists()) {
    return fail(ErrorCode::kIo, "DDS topic " + topic + " cannot be read: " + made.reader_.error());
  }
  static_cast<void>(dds_set_status_mask(made.reader_.get(), DDS_DATA_AVAILABLE_STATUS));
  if (const dds_return_t attached = dds_waitset_attach(link.waitset(), made.reader_.get(), 0);
      attached != DDS_RETCODE_OK) {
    return fail(ErrorCode::kIo, "DDS topic " + topic + " cannot be waited for: " + dds_strretcode(-attached));
  }
  return made;
}

std::uint32_t TopicReader::writers() const noexcept {
  const ForeignCall foreign;
  dds_subscription_matched_status_t status{};
  return dds_get_subscription_matched_status(reader_.get(), &status) == DDS_RETCODE_OK ? status.current_count : 0;
}

}  // namespace kinetrace::publishing

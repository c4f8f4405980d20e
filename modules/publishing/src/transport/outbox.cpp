#include "transport/outbox.hpp"

#include <algorithm>
#include <utility>

namespace kinetrace::publishing {
namespace {

constexpr std::memory_order kRelaxed = std::memory_order_relaxed;

}  // namespace

Result<Writer> Writer::create(dds_entity_t participant, const dds_topic_descriptor_t& type, const std::string& topic,
                              const TopicQos& qos, Priority priority) {
  const ForeignCall foreign;
  const Qos settings = make_qos(qos);
  Writer made;
  made.priority_ = priority;
  made.is_kept_ = qos.keeps_last;
  made.topic_ = Entity(dds_create_topic(participant, &type, topic.c_str(), nullptr, nullptr));
  if (!made.topic_.exists()) {
    return fail(ErrorCode::kIo, "DDS topic " + topic + " cannot be made: " + made.topic_.error());
  }
  made.writer_ = Entity(dds_create_writer(participant, made.topic_.get(), settings.get(), nullptr));
  if (!made.writer_.exists()) {
    return fail(ErrorCode::kIo, "DDS topic " + topic + " cannot be written: " + made.writer_.error());
  }
  return made;
}

Status make_writers(dds_entity_t participant, std::span<const TopicSpec> specs) {
  for (const TopicSpec& spec : specs) {
    Result<Writer> writer = Writer::create(participant, spec.type, spec.name, spec.qos, spec.priority);
    if (!writer) {
      return Unexpected(writer.error());
    }
    spec.writer = std::move(*writer);
  }
  return {};
}

std::uint32_t Writer::readers() const noexcept {
  const ForeignCall foreign;
  dds_publication_matched_status_t status{};
  return dds_get_publication_matched_status(writer_.get(), &status) == DDS_RETCODE_OK ? status.current_count : 0;
}

void Outbox::write(const Writer& writer, const void* message, std::size_t bytes) noexcept {
  const std::size_t sent_bytes = bytes * std::max<std::size_t>(1, writer.readers());
  if (writer.is_kept()) {
    budget_.charge(sent_bytes);  // Sent unconditionally: small and rare, and some are offered only once.
  } else if (!budget_.take(sent_bytes, writer.priority())) {
    skipped_.fetch_add(1, kRelaxed);
    return;
  }
  const ForeignCall foreign;
  if (dds_write(writer.get(), message) != DDS_RETCODE_OK) {
    errors_.fetch_add(1, kRelaxed);
    return;
  }
  messages_.fetch_add(1, kRelaxed);
  bytes_.fetch_add(sent_bytes, kRelaxed);
}

void Outbox::count_into(PublishCounters& counters) const noexcept {
  counters.messages = messages_.load(kRelaxed);
  counters.bytes = bytes_.load(kRelaxed);
  counters.skipped_for_budget = skipped_.load(kRelaxed);
  counters.write_errors = errors_.load(kRelaxed);
}

}  // namespace kinetrace::publishing

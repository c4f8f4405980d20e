// Sends all messages within the budget and counts them.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "kinetrace/core/result.hpp"
#include "kinetrace/publishing/publisher.hpp"
#include "link/dds_entity.hpp"
#include "transport/byte_budget.hpp"
#include "transport/topic_qos.hpp"

namespace kinetrace::publishing {

/// A topic and its writer.
class Writer {
 public:
  Writer() = default;
  /// Errors: kIo, with the topic and the library's message.
  [[nodiscard]] static Result<Writer> create(dds_entity_t participant, const dds_topic_descriptor_t& type,
                                             const std::string& topic, const TopicQos& qos, Priority priority);

  [[nodiscard]] dds_entity_t get() const noexcept { return writer_.get(); }
  [[nodiscard]] Priority priority() const noexcept { return priority_; }
  /// Number of matched readers.
  [[nodiscard]] std::uint32_t readers() const noexcept;
  /// Late readers receive the last message, so it is written even without readers.
  [[nodiscard]] bool is_kept() const noexcept { return is_kept_; }

 private:
  Entity topic_;
  Entity writer_;  // Declared after the topic, so that it is destroyed first.
  Priority priority_ = Priority::kEssential;
  bool is_kept_ = false;
};

/// Specification of a writer.
struct TopicSpec {
  Writer& writer;
  const dds_topic_descriptor_t& type;
  std::string name;
  TopicQos qos;
  Priority priority;
};
/// Creates all writers. Errors: those of Writer::create, from the first that fails.
[[nodiscard]] Status make_writers(dds_entity_t participant, std::span<const TopicSpec> specs);

/// Writes messages that have readers and fit the budget.
class Outbox {
 public:
  Outbox(int bytes_per_second, int piece_bytes) noexcept : budget_(bytes_per_second, piece_bytes) {}

  void refill(std::int64_t now_ns) noexcept { budget_.refill(now_ns); }
  /// False if a message would not be sent.
  [[nodiscard]] static bool is_wanted(const Writer& writer) noexcept {
    return writer.is_kept() || writer.readers() > 0;
  }
  /// `message` is of the writer's type; `bytes` is its approximate size on the wire.
  void write(const Writer& writer, const void* message, std::size_t bytes) noexcept;
  void count_into(PublishCounters& counters) const noexcept;

 private:
  ByteBudget budget_;
  // Written by one thread, read by any; relaxed, since they order nothing.
  std::atomic<std::uint64_t> messages_ = 0;
  std::atomic<std::uint64_t> bytes_ = 0;
  std::atomic<std::uint64_t> skipped_ = 0;
  std::atomic<std::uint64_t> errors_ = 0;
};

}  // namespace kinetrace::publishing

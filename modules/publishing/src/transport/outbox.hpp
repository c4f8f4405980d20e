// The way every message takes out: within the budget, and counted.
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
  /// Errors: kIo, with the topic and what the library says.
  [[nodiscard]] static Result<Writer> create(dds_entity_t participant, const dds_topic_descriptor_t& type,
                                             const std::string& topic, const TopicQos& qos, Priority priority);

  [[nodiscard]] dds_entity_t get() const noexcept { return writer_.get(); }
  [[nodiscard]] Priority priority() const noexcept { return priority_; }
  /// Readers that get what is written now.
  [[nodiscard]] std::uint32_t readers() const noexcept;
  /// Readers that come later get the last message too, so it is written without any.
  [[nodiscard]] bool is_kept() const noexcept { return is_kept_; }

 private:
  Entity topic_;
  Entity writer_;  // After the topic, so that it goes first.
  Priority priority_ = Priority::kEssential;
  bool is_kept_ = false;
};

/// A writer to be made.
struct TopicSpec {
  Writer& writer;
  const dds_topic_descriptor_t& type;
  std::string name;
  TopicQos qos;
  Priority priority;
};
/// Errors: as Writer::create, of the first that fails.
[[nodiscard]] Status make_writers(dds_entity_t participant, std::span<const TopicSpec> specs);

/// Writes what somebody reads and the budget allows.
class Outbox {
 public:
  Outbox(int bytes_per_second, int piece_bytes) noexcept : budget_(bytes_per_second, piece_bytes) {}

  void refill(std::int64_t now_ns) noexcept { budget_.refill(now_ns); }
  /// False where filling in a message would be in vain.
  [[nodiscard]] static bool is_wanted(const Writer& writer) noexcept {
    return writer.is_kept() || writer.readers() > 0;
  }
  /// `message` is of the writer's type, `bytes` what it is about on the wire.
  void write(const Writer& writer, const void* message, std::size_t bytes) noexcept;
  void count_into(PublishCounters& counters) const noexcept;

 private:
  ByteBudget budget_;
  // Written by one thread, read by any; they order nothing.
  std::atomic<std::uint64_t> messages_ = 0;
  std::atomic<std::uint64_t> bytes_ = 0;
  std::atomic<std::uint64_t> skipped_ = 0;
  std::atomic<std::uint64_t> errors_ = 0;
};

}  // namespace kinetrace::publishing

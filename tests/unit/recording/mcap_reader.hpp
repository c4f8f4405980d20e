// A strict reader of MCAP, written from the specification alone: every length and checksum must be right.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace kinetrace::recording::test {

struct ReadMessage {
  std::uint16_t channel = 0;
  std::uint32_t sequence = 0;
  std::uint64_t log_time = 0;
  std::uint64_t publish_time = 0;
  std::string data;
  bool operator==(const ReadMessage&) const = default;
};

struct ReadChannel {
  std::uint16_t schema = 0;
  std::string topic;
  std::string encoding;
  std::map<std::string, std::string> metadata;
  bool operator==(const ReadChannel&) const = default;
};

struct ReadSchema {
  std::string name;
  std::string encoding;
  std::string data;
  bool operator==(const ReadSchema&) const = default;
};

struct ReadIndex {
  std::uint64_t start_time = 0;
  std::uint64_t end_time = 0;
  std::uint64_t chunk_offset = 0;
  std::uint64_t chunk_bytes = 0;
  std::map<std::uint16_t, std::uint64_t> message_indexes;
  std::uint64_t message_index_bytes = 0;
};

struct ReadStatistics {
  std::uint64_t messages = 0;
  std::uint32_t chunks = 0;
  std::uint64_t first_time = 0;
  std::uint64_t last_time = 0;
  std::map<std::uint16_t, std::uint64_t> by_channel;
};

struct ReadMcap {
  std::string profile;
  std::string library;
  std::map<std::uint16_t, ReadSchema> schemas;
  std::map<std::uint16_t, ReadChannel> channels;
  std::vector<ReadMessage> messages;
  // From the summary, if there is one.
  bool is_finished = false;
  std::map<std::uint16_t, ReadSchema> summary_schemas;
  std::map<std::uint16_t, ReadChannel> summary_channels;
  std::optional<ReadStatistics> statistics;
  std::vector<ReadIndex> index;
  std::map<std::uint8_t, std::uint64_t> group_starts;
};

/// Reads from the beginning to the first incomplete record, which is no error. Throws std::runtime_error for any other
/// fault.
[[nodiscard]] ReadMcap read_mcap(const std::string& bytes);

/// The message at a place that an index names: in a chunk, at an offset into its records.
[[nodiscard]] ReadMessage read_indexed(const std::string& bytes, const ReadIndex& index, std::uint16_t channel);

}  // namespace kinetrace::recording::test

#include "mcap_reader.hpp"

#include <stdexcept>
#include <string_view>

namespace kinetrace::recording::test {
namespace {

constexpr std::string_view kMagic{"\x89MCAP0\r\n", 8};

void require(bool holds, const char* what) {
  if (!holds) {
    throw std::runtime_error(what);
  }
}

// Bit by bit, unlike the tested implementation.
std::uint32_t crc32(std::string_view bytes) {
  std::uint32_t crc = 0xFFFFFFFFU;
  for (const char byte : bytes) {
    crc ^= static_cast<std::uint8_t>(byte);
    for (int bit = 0; bit < 8; ++bit) {
      crc = (crc >> 1U) ^ ((crc & 1U) != 0 ? 0xEDB88320U : 0U);
    }
  }
  return ~crc;
}

class Input {
 public:
  explicit Input(std::string_view bytes) : bytes_(bytes) {}
  template <typename Integer>
  Integer number() {
    const std::string_view taken = take(sizeof(Integer));
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < sizeof(Integer); ++i) {
      value |= std::uint64_t{static_cast<std::uint8_t>(taken[i])} << (8 * i);
    }
    return static_cast<Integer>(value);
  }
  std::string text() { return std::string(take(number<std::uint32_t>())); }
  std::string_view take(std::uint64_t count) {
    require(count <= bytes_.size(), "a record is too short");
    const std::string_view taken = bytes_.substr(0, count);
    bytes_.remove_prefix(count);
    return taken;
  }
  std::string_view rest() { return take(bytes_.size()); }
  [[nodiscard]] bool empty() const { return bytes_.empty(); }
  void require_end() const { require(bytes_.empty(), "a record is too long"); }

 private:
  std::string_view bytes_;
};

struct Record {
  std::uint8_t opcode = 0;
  std::string_view content;
  std::uint64_t end = 0;
};

/// None where the record at `offset` is not whole.
std::optional<Record> record_at(std::string_view bytes, std::uint64_t offset) {
  if (offset + 9 > bytes.size()) {
    return std::nullopt;
  }
  Input input(bytes.substr(offset));
  Record record;
  record.opcode = input.number<std::uint8_t>();
  const auto length = input.number<std::uint64_t>();
  if (length > bytes.size() - offset - 9) {
    return std::nullopt;
  }
  record.content = input.take(length);
  record.end = offset + 9 + length;
  return record;
}

ReadMessage message_of(std::string_view content) {
  Input input(content);
  ReadMessage message;
  message.channel = input.number<std::uint16_t>();
  message.sequence = input.number<std::uint32_t>();
  message.log_time = input.number<std::uint64_t>();
  message.publish_time = input.number<std::uint64_t>();
  message.data = input.rest();
  return message;
}

/// The records of a chunk, whose checksum must be right.
std::string_view chunk_records(std::string_view content) {
  Input input(content);
  static_cast<void>(input.take(16));
  const auto size = input.number<std::uint64_t>();
  const auto crc = input.number<std::uint32_t>();
  require(input.text().empty(), "a chunk is compressed");
  const std::string_view records = input.take(input.number<std::uint64_t>());
  input.require_end();
  require(records.size() == size, "a chunk has another size");
  require(crc32(records) == crc, "a chunk has another checksum");
  return records;
}

class Reader {
 public:
  explicit Reader(std::string_view bytes) : bytes_(bytes) {}

  ReadMcap read() {
    require(bytes_.substr(0, 8) == kMagic.substr(0, bytes_.size()), "no magic");
    std::uint64_t offset = 8;
    while (const std::optional<Record> record = record_at(bytes_, offset)) {
      take(*record, offset);
      offset = record->end;
      if (record->opcode == 0x02) {
        require_footer(record->content, offset);
        break;
      }
    }
    return read_;
  }

 private:
  void take(const Record& record, std::uint64_t offset) {
    Input input(record.content);
    switch (record.opcode) {
      case 0x01:
        read_.profile = input.text();
        read_.library = input.text();
        input.require_end();
        break;
      case 0x03: schema(input); break;
      case 0x04: channel(input); break;
      case 0x06: chunk(record.content); break;
      case 0x07: break;  // Looked at through the index.
      case 0x08: index(input); break;
      case 0x0B: statistics(input); break;
      case 0x0E: group(input); break;
      case 0x0F:
        require(input.number<std::uint32_t>() == crc32(bytes_.substr(0, offset)), "the data has another checksum");
        data_end_ = record.end;
        break;
      case 0x02: break;
      default: throw std::runtime_error("a record of another kind");
    }
  }

  void schema(Input& input) {
    const auto id = input.number<std::uint16_t>();
    require(id != 0, "a schema without id");
    ReadSchema schema;
    schema.name = input.text();
    schema.encoding = input.text();
    schema.data = input.text();
    input.require_end();
    (data_end_ != 0 ? read_.summary_schemas : read_.schemas)[id] = schema;
  }
  void channel(Input& input) {
    const auto id = input.number<std::uint16_t>();
    ReadChannel channel;
    channel.schema = input.number<std::uint16_t>();
    channel.topic = input.text();
    channel.encoding = input.text();
    Input map(input.take(input.number<std::uint32_t>()));
    while (!map.empty()) {
      const std::string key = map.text();
      channel.metadata[key] = map.text();
    }
    input.require_end();
    require(read_.schemas.contains(channel.schema), "a channel before its schema");
    (data_end_ != 0 ? read_.summary_channels : read_.channels)[id] = channel;
  }
  void chunk(std::string_view content) {
    const std::string_view records = chunk_records(content);
    for (std::uint64_t offset = 0; offset < records.size();) {
      const std::optional<Record> record = record_at(records, offset);
      require(record && record->opcode == 0x05, "a chunk holds no message");
      read_.messages.push_back(message_of(record->content));
      require(read_.channels.contains(read_.messages.back().channel), "a message before its channel");
      offset = record->end;
    }
  }
  void index(Input& input) {
    ReadIndex index;
    index.start_time = input.number<std::uint64_t>();
    index.end_time = input.number<std::uint64_t>();
    index.chunk_offset = input.number<std::uint64_t>();
    index.chunk_bytes = input.number<std::uint64_t>();
    Input map(input.take(input.number<std::uint32_t>()));
    while (!map.empty()) {
      const auto channel = map.number<std::uint16_t>();
      index.message_indexes[channel] = map.number<std::uint64_t>();
    }
    index.message_index_bytes = input.number<std::uint64_t>();
    require(input.text().empty(), "an index of a compressed chunk");
    static_cast<void>(input.take(16));
    input.require_end();
    read_.index.push_back(index);
  }
  void statistics(Input& input) {
    ReadStatistics statistics;
    statistics.messages = input.number<std::uint64_t>();
    require(input.number<std::uint16_t>() == read_.schemas.size(), "another number of schemas");
    require(input.number<std::uint32_t>() == read_.channels.size(), "another number of channels");
    require(input.number<std::uint64_t>() == 0, "attachments or metadata");
    statistics.chunks = input.number<std::uint32_t>();
    statistics.first_time = input.number<std::uint64_t>();
    statistics.last_time = input.number<std::uint64_t>();
    Input map(input.take(input.number<std::uint32_t>()));
    while (!map.empty()) {
      const auto channel = map.number<std::uint16_t>();
      statistics.by_channel[channel] = map.number<std::uint64_t>();
    }
    input.require_end();
    read_.statistics = statistics;
  }
  void group(Input& input) {
    const auto opcode = input.number<std::uint8_t>();
    const auto start = input.number<std::uint64_t>();
    const auto length = input.number<std::uint64_t>();
    input.require_end();
    for (std::uint64_t offset = start; offset < start + length;) {
      const std::optional<Record> record = record_at(bytes_, offset);
      require(record && record->opcode == opcode, "a group of records is not where it is said to be");
      offset = record->end;
    }
    read_.group_starts[opcode] = start;
  }
  void require_footer(std::string_view content, std::uint64_t end) {
    Input input(content);
    const auto summary_start = input.number<std::uint64_t>();
    static_cast<void>(input.number<std::uint64_t>());
    const auto crc = input.number<std::uint32_t>();
    input.require_end();
    require(summary_start == data_end_, "the summary is not where it is said to be");
    require(crc32(bytes_.substr(summary_start, end - 4 - summary_start)) == crc, "the summary has another checksum");
    read_.is_finished = bytes_.substr(end) == kMagic;
  }

  std::string_view bytes_;
  ReadMcap read_;
  std::uint64_t data_end_ = 0;
};

}  // namespace

ReadMcap read_mcap(const std::string& bytes) {
  return Reader(bytes).read();
}

ReadMessage read_indexed(const std::string& bytes, const ReadIndex& index, std::uint16_t channel) {
  const std::optional<Record> list = record_at(bytes, index.message_indexes.at(channel));
  require(list && list->opcode == 0x07, "no message index");
  require(list->end == index.chunk_offset + index.chunk_bytes + index.message_index_bytes, "indexes have another size");
  Input input(list->content);
  require(input.number<std::uint16_t>() == channel, "the index of another channel");
  require(input.number<std::uint32_t>() == 16, "more than one message");
  require(input.number<std::uint64_t>() == index.start_time, "another time");
  const auto offset = input.number<std::uint64_t>();
  const std::optional<Record> chunk = record_at(bytes, index.chunk_offset);
  require(chunk && chunk->opcode == 0x06 && chunk->end == index.chunk_offset + index.chunk_bytes, "no chunk");
  const std::optional<Record> message = record_at(chunk_records(chunk->content), offset);
  require(message && message->opcode == 0x05, "no message");
  return message_of(message->content);
}

}  // namespace kinetrace::recording::test

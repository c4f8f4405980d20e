#include <array>

#include "kinetrace/core/config_check.hpp"
#include "kinetrace/core/crc32.hpp"
#include "mcap_file.hpp"

namespace kinetrace::recording {
namespace {

/// Index entry of a chunk with one message.
struct ChunkFacts {
  std::uint64_t offset = 0;
  std::uint64_t chunk_bytes = 0;  ///< With its prefix.
  std::uint64_t time_ns = 0;
  std::uint64_t records_bytes = 0;
  std::uint16_t channel = 0;
};

// Behind the prefix: two times, uncompressed size and checksum, the empty name of a compression, size of the records;
// then the message's prefix and channel.
constexpr std::uint64_t kChunkHeaderBytes = 8 + 8 + 8 + 4 + 4 + 8;
constexpr std::uint64_t kChunkToChannelBytes = kMcapPrefixBytes + kChunkHeaderBytes + kMcapPrefixBytes + 2;

void append_chunk_index(const ChunkFacts& chunk, McapBytes& out) {
  out.record(McapOpcode::kChunkIndex, [&](McapBytes& content) {
    content.number(chunk.time_ns).number(chunk.time_ns).number(chunk.offset).number(chunk.chunk_bytes);
    content.sized<std::uint32_t>(
        [&](McapBytes& map) { map.number(chunk.channel).number(chunk.offset + chunk.chunk_bytes); });
    content.number(kMcapMessageIndexBytes).text("").number(chunk.records_bytes).number(chunk.records_bytes);
  });
}

void append_statistics(const McapContent& content, McapBytes& out) {
  out.record(McapOpcode::kStatistics, [&](McapBytes& record) {
    constexpr std::uint32_t kNone = 0;  // Attachments, metadata.
    record.number(content.messages).number(static_cast<std::uint16_t>(content.schemas.size()));
    record.number(static_cast<std::uint32_t>(content.channels.size())).number(kNone).number(kNone);
    record.number(static_cast<std::uint32_t>(content.messages));  // Chunks.
    record.number(content.first_time_ns).number(content.last_time_ns);
    record.sized<std::uint32_t>([&](McapBytes& map) {
      for (std::size_t i = 0; i < content.channels.size(); ++i) {
        map.number(static_cast<std::uint16_t>(i)).number(content.channels[i].messages);
      }
    });
  });
}

/// Writes the summary by groups and tracks their offsets and the checksum.
class Summary {
 public:
  explicit Summary(McapFile& file) : file_(file), data_end_(file.end) {}

  /// `fill(bytes)` appends all records of one kind.
  template <typename Fill>
  [[nodiscard]] Status group(McapOpcode opcode, Fill&& fill) {
    const std::uint64_t start = position();
    if (Status filled = fill(out_); !filled) {
      return filled;
    }
    if (position() > start) {
      offsets_.record(McapOpcode::kSummaryOffset, [&](McapBytes& record) {
        record.number(static_cast<std::uint8_t>(opcode)).number(start).number(position() - start);
      });
    }
    return {};
  }
  /// Flushes to the file to bound memory.
  [[nodiscard]] Status flush_if_large() {
    constexpr std::size_t kLarge = 65536;
    return out_.size() < kLarge ? Status{} : flush();
  }
  [[nodiscard]] std::uint64_t data_end() const noexcept { return data_end_; }

  /// The last bytes of the file.
  [[nodiscard]] Status finish() {
    constexpr std::uint64_t kFooterBytes = 8 + 8 + 4;
    const std::uint64_t offsets_at = position();
    out_.raw(offsets_.span());
    // The footer's checksum includes the footer up to the checksum itself.
    out_.number(static_cast<std::uint8_t>(McapOpcode::kFooter)).number(kFooterBytes);
    out_.number(data_end_).number(offsets_at);
    const std::uint32_t checksum = Crc32(crc_).update(out_.span()).value();
    out_.number(checksum).raw(std::as_bytes(std::span(kMcapMagic)));
    return flush();
  }

 private:
  [[nodiscard]] std::uint64_t position() const noexcept { return file_.end + out_.size(); }
  [[nodiscard]] Status flush() {
    crc_.update(out_.span());
    Status written = file_.append(out_.span());
    out_.clear();
    return written;
  }

  McapFile& file_;
  std::uint64_t data_end_;
  McapBytes out_;
  McapBytes offsets_;
  Crc32 crc_;
};

Status read_chunk(const McapFile& file, ChunkFacts& chunk) {
  std::array<std::byte, kChunkToChannelBytes> head{};
  if (Status read = read_at(file.file, chunk.offset, head, file.path); !read) {
    return read;
  }
  const std::span<const std::byte> content = std::span(head).subspan(kMcapPrefixBytes);
  McapNumbers numbers(content);
  chunk.time_ns = numbers.next<std::uint64_t>();
  static_cast<void>(numbers.next<std::uint64_t>());
  chunk.records_bytes = numbers.next<std::uint64_t>();
  chunk.channel = McapNumbers(std::span(head).last<2>()).next<std::uint16_t>();
  return {};
}

Status append_chunk_indexes(const McapFile& file, Summary& summary, McapBytes& out) {
  for (ChunkFacts record{.offset = kMcapMagic.size()}; record.offset < summary.data_end();
       record.offset += record.chunk_bytes) {
    std::array<std::byte, kMcapPrefixBytes> prefix{};
    if (Status read = read_at(file.file, record.offset, prefix, file.path); !read) {
      return read;
    }
    McapNumbers numbers(prefix);
    const auto opcode = static_cast<McapOpcode>(numbers.next<std::uint8_t>());
    const auto content_bytes = numbers.next<std::uint64_t>();
    // Data read back from a disk may differ from the data written.
    if (content_bytes > summary.data_end() || record.offset + kMcapPrefixBytes > summary.data_end() - content_bytes) {
      return fail(ErrorCode::kIo, file.path.string() +
                                      ": was read back damaged; it has no index, readers find its "
                                      "messages from the beginning");
    }
    record.chunk_bytes = kMcapPrefixBytes + content_bytes;
    if (opcode != McapOpcode::kChunk) {
      continue;
    }
    if (Status read = read_chunk(file, record); !read) {
      return read;
    }
    append_chunk_index(record, out);
    if (Status flushed = summary.flush_if_large(); !flushed) {
      return flushed;
    }
  }
  return {};
}

}  // namespace

Status write_mcap_summary(McapFile& file, const McapContent& content) {
  Summary summary(file);
  const auto schemas = [&](McapBytes& out) -> Status {
    for (std::size_t i = 0; i < content.schemas.size(); ++i) {
      append_schema(content, i, out);
    }
    return {};
  };
  const auto channels = [&](McapBytes& out) -> Status {
    for (std::size_t i = 0; i < content.channels.size(); ++i) {
      append_channel(content, i, out);
    }
    return {};
  };
  const auto statistics = [&](McapBytes& out) -> Status {
    append_statistics(content, out);
    return {};
  };
  const auto chunk_indexes = [&](McapBytes& out) { return append_chunk_indexes(file, summary, out); };
  return first_failure({summary.group(McapOpcode::kSchema, schemas), summary.group(McapOpcode::kChannel, channels),
                        summary.group(McapOpcode::kStatistics, statistics),
                        summary.group(McapOpcode::kChunkIndex, chunk_indexes), summary.finish()});
}

}  // namespace kinetrace::recording

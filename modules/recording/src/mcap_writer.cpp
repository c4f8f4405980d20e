#include "kinetrace/recording/mcap_writer.hpp"

#include <algorithm>
#include <limits>
#include <optional>
#include <system_error>
#include <unistd.h>

#include "kinetrace/core/crc32.hpp"
#include "mcap_file.hpp"

namespace kinetrace::recording {
namespace {

std::uint64_t unsigned_time(std::int64_t time_ns) noexcept {
  return static_cast<std::uint64_t>(std::max<std::int64_t>(0, time_ns));
}

/// The id of the schema for `type`, which is added if it is new.
std::uint16_t schema_for(const McapTopic& topic, McapContent& content, McapBytes& out) {
  const auto known = std::find_if(content.schemas.begin(), content.schemas.end(),
                                  [&](const McapSchema& schema) { return schema.type == topic.type; });
  const auto index = static_cast<std::size_t>(known - content.schemas.begin());
  if (known == content.schemas.end()) {
    content.schemas.push_back({topic.type, topic.definition});
    append_schema(content, index, out);
  }
  return static_cast<std::uint16_t>(index + 1);
}

}  // namespace

void append_schema(const McapContent& content, std::size_t index, McapBytes& out) {
  const McapSchema& schema = content.schemas[index];
  out.record(McapOpcode::kSchema, [&](McapBytes& record) {
    record.number(static_cast<std::uint16_t>(index + 1)).text(schema.type).text("ros2msg").text(schema.definition);
  });
}

void append_channel(const McapContent& content, std::size_t index, McapBytes& out) {
  const McapChannel& channel = content.channels[index];
  out.record(McapOpcode::kChannel, [&](McapBytes& record) {
    record.number(static_cast<std::uint16_t>(index)).number(channel.schema_id).text(channel.topic).text("cdr");
    record.sized<std::uint32_t>([&](McapBytes& map) {
      for (const auto& [key, value] : channel.metadata) {
        map.text(key).text(value);
      }
    });
  });
}

Status McapFile::append(std::span<const std::byte> bytes) {
  if (Status written = write_at(file, end, bytes, path); !written) {
    cut(end);
    return written;
  }
  end += bytes.size();
  return {};
}

void McapFile::cut(std::uint64_t bytes) noexcept {
  // If truncation fails, readers stop at the torn record.
  static_cast<void>(::ftruncate(file.get(), static_cast<off_t>(bytes)) == 0);
  end = bytes;
}

struct McapWriter::Impl {
  McapFile file;
  McapContent content{};
  Crc32 data_crc{};
  McapBytes records{};  ///< Contents of a chunk, and bytes to append next; buffers are reused.
  McapBytes out{};
  std::optional<Error> failure{};
  bool is_finished = false;

  /// `out`, as part of the data section.
  Status append() {
    Status written = file.append(out.span());
    if (written) {
      data_crc.update(out.span());
    } else {
      failure = written.error();
    }
    return written;
  }
};

McapWriter::McapWriter(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
McapWriter::McapWriter(McapWriter&&) noexcept = default;
McapWriter& McapWriter::operator=(McapWriter&&) noexcept = default;
McapWriter::~McapWriter() = default;

Result<McapWriter> McapWriter::create(const std::filesystem::path& path, std::string_view library) {
  std::error_code ignored;
  if (std::filesystem::exists(path, ignored)) {
    return fail(ErrorCode::kIo, path.string() + " exists already; name a new file");
  }
  Result<FileHandle> file = open_file(path, OpenMode::kCreate);
  if (!file) {
    return Unexpected(file.error());
  }
  std::unique_ptr<Impl> impl(new Impl{.file = {path, std::move(*file)}});
  impl->out.raw(std::as_bytes(std::span(kMcapMagic)));
  impl->out.record(McapOpcode::kHeader, [&](McapBytes& record) { record.text("ros2").text(library); });
  if (const Status written = impl->append(); !written) {
    return Unexpected(written.error());
  }
  return McapWriter(std::move(impl));
}

Result<std::uint16_t> McapWriter::add_topic(const McapTopic& topic) {
  Impl& self = *impl_;
  if (self.failure) {
    return Unexpected(*self.failure);
  }
  const std::size_t index = self.content.channels.size();
  if (index == std::numeric_limits<std::uint16_t>::max()) {
    return fail(ErrorCode::kCapacity, self.file.path.string() + ": an MCAP file holds 65535 topics at most");
  }
  self.out.clear();
  const std::uint16_t schema_id = schema_for(topic, self.content, self.out);
  self.content.channels.push_back({topic.name, schema_id, topic.metadata});
  append_channel(self.content, index, self.out);
  if (const Status written = self.append(); !written) {
    return Unexpected(written.error());
  }
  return static_cast<std::uint16_t>(index);
}

Status McapWriter::write(std::uint16_t channel, std::int64_t received_ns, std::int64_t sent_ns,
                         std::span<const std::byte> cdr) {
  Impl& self = *impl_;
  if (self.failure) {
    return Unexpected(*self.failure);
  }
  McapContent& content = self.content;
  if (channel >= content.channels.size() || self.is_finished) {
    return fail(ErrorCode::kInvalidArgument, self.file.path.string() + ": a message for topic " +
                                                 std::to_string(channel) +
                                                 (self.is_finished ? " after finish()" : ", which was never added"));
  }
  McapChannel& to = content.channels[channel];
  const std::uint64_t time_ns = unsigned_time(received_ns);
  self.records.clear();
  self.records.record(McapOpcode::kMessage, [&](McapBytes& record) {
    record.number(channel).number(static_cast<std::uint32_t>(to.messages));
    record.number(time_ns).number(unsigned_time(sent_ns)).raw(cdr);
  });
  const std::span<const std::byte> records = self.records.span();
  self.out.clear();
  self.out.record(McapOpcode::kChunk, [&](McapBytes& record) {
    record.number(time_ns).number(time_ns).number(std::uint64_t{records.size()});
    record.number(Crc32().update(records).value()).text("");
    record.sized<std::uint64_t>([&](McapBytes& held) { held.raw(records); });
  });
  self.out.record(McapOpcode::kMessageIndex, [&](McapBytes& record) {
    constexpr std::uint64_t kAtBegin = 0;
    record.number(channel).sized<std::uint32_t>([&](McapBytes& list) { list.number(time_ns).number(kAtBegin); });
  });
  if (Status written = self.append(); !written) {
    return written;
  }
  content.first_time_ns = content.messages == 0 ? time_ns : std::min(content.first_time_ns, time_ns);
  content.last_time_ns = std::max(content.last_time_ns, time_ns);
  ++to.messages;
  ++content.messages;
  return {};
}

Status McapWriter::finish() {
  Impl& self = *impl_;
  if (self.failure) {
    return Unexpected(*self.failure);
  }
  if (self.is_finished) {
    return {};
  }
  self.is_finished = true;
  const std::uint64_t messages_end = self.file.end;
  self.out.clear();
  self.out.record(McapOpcode::kDataEnd, [&](McapBytes& record) { record.number(self.data_crc.value()); });
  Status written = self.file.append(self.out.span());
  if (written) {
    written = write_mcap_summary(self.file, self.content);
  }
  if (!written) {
    self.failure = written.error();
    self.file.cut(messages_end);
    return written;
  }
  const int error = self.file.file.close();
  return error == 0 ? Status{} : Status(file_error("close", self.file.path, error));
}

McapCounters McapWriter::counters() const noexcept {
  return {impl_->content.messages, impl_->file.end};
}

}  // namespace kinetrace::recording

// Shared by the parts of the MCAP writer: the file and its contents.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "buffered_file.hpp"
#include "mcap_records.hpp"

namespace kinetrace::recording {

struct McapSchema {
  std::string type;
  std::string definition;
};

struct McapChannel {
  std::string topic;
  std::uint16_t schema_id = 0;  ///< Position in the schemas, from 1.
  std::vector<std::pair<std::string, std::string>> metadata;
  std::uint64_t messages = 0;
};

struct McapContent {
  std::vector<McapSchema> schemas;
  std::vector<McapChannel> channels;  ///< The id is the position, from 0.
  std::uint64_t messages = 0;
  std::uint64_t first_time_ns = 0;  ///< Of the messages.
  std::uint64_t last_time_ns = 0;
};

/// A file that grows by whole records.
struct McapFile {
  std::filesystem::path path;
  FileHandle file;
  std::uint64_t end = 0;  ///< End of the last whole record.

  /// Appends all bytes or none. Errors: kIo.
  [[nodiscard]] Status append(std::span<const std::byte> bytes);
  /// Truncates the file to `bytes`.
  void cut(std::uint64_t bytes) noexcept;
};

/// Fixed sizes of records: one message per chunk, uncompressed.
inline constexpr std::uint64_t kMcapMessageIndexBytes = kMcapPrefixBytes + 2 + 4 + 8 + 8;

void append_schema(const McapContent& content, std::size_t index, McapBytes& out);
void append_channel(const McapContent& content, std::size_t index, McapBytes& out);

/// Writes everything after the data section, the current end of `file`. The index is built from the file itself, so
/// memory does not grow with its length. Errors: kIo.
[[nodiscard]] Status write_mcap_summary(McapFile& file, const McapContent& content);

}  // namespace kinetrace::recording

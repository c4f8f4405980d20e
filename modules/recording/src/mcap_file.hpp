// What the parts of the MCAP writer share: the file, and what is in it.
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
  std::vector<McapChannel> channels;  ///< An id is the position, from 0.
  std::uint64_t messages = 0;
  std::uint64_t first_time_ns = 0;  ///< Of the messages.
  std::uint64_t last_time_ns = 0;
};

/// A file that grows by whole pieces.
struct McapFile {
  std::filesystem::path path;
  FileHandle file;
  std::uint64_t end = 0;  ///< Of what is whole.

  /// All of it, or nothing. Errors: kIo.
  [[nodiscard]] Status append(std::span<const std::byte> bytes);
  /// Takes back everything after the first `bytes`.
  void cut(std::uint64_t bytes) noexcept;
};

/// One message per chunk, nothing compressed: what is fixed about its records.
inline constexpr std::uint64_t kMcapMessageIndexBytes = kMcapPrefixBytes + 2 + 4 + 8 + 8;

void append_schema(const McapContent& content, std::size_t index, McapBytes& out);
void append_channel(const McapContent& content, std::size_t index, McapBytes& out);

/// Everything after the data section, which `file` holds up to its end. The index is made from the file itself, so
/// memory does not grow with its length. Errors: kIo.
[[nodiscard]] Status write_mcap_summary(McapFile& file, const McapContent& content);

}  // namespace kinetrace::recording

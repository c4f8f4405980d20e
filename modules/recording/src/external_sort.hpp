// External merge sort of a file of records.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <utility>

#include "buffered_file.hpp"
#include "spool_reader.hpp"

namespace kinetrace::recording {

/// Merge sort on disk: sorted runs as long as `memory`, then merges of up to kMaxWays runs at a time until one is left.
/// Takes `memory` (64-byte aligned, at least 32 KiB), two open files and disk space for one copy; n records in memory
/// for m cost about 1 + log(n/m) / log(kMaxWays) passes.
template <typename Record, typename Less>
class ExternalSort {
 public:
  ExternalSort(std::filesystem::path path, std::span<std::byte> memory, Less less)
      : path_(std::move(path)), memory_(memory), less_(less) {}

  [[nodiscard]] Status run() {
    Result<FileHandle> file = open_file(path_, OpenMode::kUpdate);
    if (!file) {
      return Unexpected(file.error());
    }
    const Result<std::uint64_t> bytes = file_size(*file, path_);
    if (!bytes) {
      return Unexpected(bytes.error());
    }
    count_ = *bytes / sizeof(Record);
    const std::uint64_t run_length = memory_.size() / sizeof(Record);
    if (Status sorted = sort_runs(*file, run_length); !sorted || count_ <= run_length) {
      return sorted;
    }
    return merge_runs(std::move(*file), run_length);
  }

 private:
  static constexpr std::size_t kMaxWays = 15;

  Status sort_runs(const FileHandle& file, std::uint64_t run_length) {
    Record* records = reinterpret_cast<Record*>(memory_.data());
    for (std::uint64_t first = 0; first < count_; first += run_length) {
      const auto length = static_cast<std::size_t>(std::min(run_length, count_ - first));
      const std::span<std::byte> bytes = memory_.first(length * sizeof(Record));
      if (Status read = read_at(file, first * sizeof(Record), bytes, path_); !read) {
        return read;
      }
      std::sort(records, records + length, less_);
      if (Status written = write_at(file, first * sizeof(Record), bytes, path_); !written) {
        return written;
      }
    }
    return {};
  }

  /// Merges between two files until one sorted run is left; the result takes the original's name.
  Status merge_runs(FileHandle source, std::uint64_t run_length) {
    const std::filesystem::path merged_path = path_.string() + ".merge";
    for (; run_length < count_; run_length *= kMaxWays) {
      Result<BufferedWriter> target = BufferedWriter::create(merged_path, slice(kMaxWays));
      if (!target) {
        return Unexpected(target.error());
      }
      for (std::uint64_t first = 0; first < count_; first += run_length * kMaxWays) {
        if (Status merged = merge_group(source, first, run_length, *target); !merged) {
          return merged;
        }
      }
      if (Status closed = target->close(); !closed) {
        return closed;
      }
      std::error_code error;
      std::filesystem::rename(merged_path, path_, error);
      if (error) {
        return file_error("replace", path_, error.value());
      }
      Result<FileHandle> reopened = open_file(path_, OpenMode::kRead);
      if (!reopened) {
        return Unexpected(reopened.error());
      }
      source = std::move(*reopened);
    }
    return {};
  }

  Status merge_group(const FileHandle& source, std::uint64_t first, std::uint64_t run_length, BufferedWriter& target) {
    std::array<std::optional<RecordCursor<Record>>, kMaxWays> runs;
    std::size_t ways = 0;
    for (; ways < kMaxWays && first < count_; ++ways, first += run_length) {
      runs[ways].emplace(source, path_, slice(ways)).set_range(first, std::min(first + run_length, count_));
    }
    for (;;) {
      RecordCursor<Record>* least = nullptr;
      const Record* least_record = nullptr;
      for (std::size_t i = 0; i < ways; ++i) {
        const Record* record = runs[i]->peek();
        if (record == nullptr) {
          if (!runs[i]->status()) {
            return runs[i]->status();
          }
        } else if (least_record == nullptr || less_(*record, *least_record)) {
          least = &*runs[i];
          least_record = record;
        }
      }
      if (least == nullptr) {
        return target.status();
      }
      target.record(*least_record);
      least->advance();
    }
  }

  [[nodiscard]] std::span<std::byte> slice(std::size_t i) const {
    constexpr std::size_t kUnit = 64;
    const std::size_t bytes = memory_.size() / (kMaxWays + 1) / kUnit * kUnit;
    return memory_.subspan(i * bytes, bytes);
  }

  std::filesystem::path path_;
  std::span<std::byte> memory_;
  Less less_;
  std::uint64_t count_ = 0;
};

template <typename Record, typename Less>
[[nodiscard]] Status sort_file(const std::filesystem::path& path, std::span<std::byte> memory, Less less) {
  return ExternalSort<Record, Less>(path, memory, less).run();
}

}  // namespace kinetrace::recording

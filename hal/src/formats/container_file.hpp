// One file of a container recording. All numbers are little-endian.
//
//     header   kHeaderBytes: "KTRAW001", width i32, height i32, nominal rate f64, length of the calibration text u32,
//     the
//              text (calibration_text.hpp), zeros, and in the last four bytes the CRC-32 of all before
//     record   kRecordHeaderBytes: "KTFR", CRC-32 of the 24 bytes that follow, frame number i64, time in ns i64, CRC-32
//              of the pixels, zero u32; then the left and the right image, row by row
//     record   ... all of one size, so that a damaged one does not hide those behind it
//
// Files are append-only: in a truncated file the records before the cut are complete.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>

#include "kinetrace/core/image_view.hpp"
#include "kinetrace/core/input_file.hpp"
#include "kinetrace/core/result.hpp"

namespace kinetrace::hal {

inline constexpr std::size_t kContainerHeaderBytes = 8192;
inline constexpr std::size_t kRecordHeaderBytes = 32;
inline constexpr const char* kContainerSuffix = ".ktraw";

struct ContainerHeader {
  int width_px = 0;
  int height_px = 0;
  double rate_hz = 0.0;
  std::string calibration;
};

struct RecordHeader {
  std::int64_t frame_index = 0;
  std::int64_t timestamp_ns = 0;
  std::uint32_t pixel_crc = 0;
};

/// Of both images together.
[[nodiscard]] std::size_t record_pixel_bytes(int width_px, int height_px) noexcept;
[[nodiscard]] std::size_t record_bytes(int width_px, int height_px) noexcept;

/// Errors: kInvalidArgument (a calibration text that does not fit).
[[nodiscard]] Result<std::string> encode_header(const ContainerHeader& header);
void encode_record_header(const RecordHeader& record, std::span<std::byte, kRecordHeaderBytes> bytes) noexcept;

/// Reads one file, which is open only during a read: a long recording has more files than a program may open.
class ContainerFile {
 public:
  /// Errors: kNotFound, kIo, kBadFormat (not a container, damaged header).
  [[nodiscard]] static Result<ContainerFile> open(const std::filesystem::path& path);

  [[nodiscard]] const ContainerHeader& header() const noexcept { return header_; }
  /// Complete records, by the file's length.
  [[nodiscard]] std::int64_t record_count() const noexcept { return record_count_; }
  /// Bytes after the last complete record: the file was cut.
  [[nodiscard]] std::size_t trailing_bytes() const noexcept { return trailing_bytes_; }
  /// Called with a record's number and its header; no header if that is damaged.
  using RecordVisitor = std::function<void(std::int64_t, const std::optional<RecordHeader>&)>;
  /// All of them, in order. Errors: kNotFound, kIo.
  [[nodiscard]] Status for_each_record(const RecordVisitor& visit) const;
  /// Both images of a record. Allocates nothing. Errors: kBadFormat (checksum), kIo.
  [[nodiscard]] InPlaceStatus read(std::int64_t number, MutableGrayView left, MutableGrayView right) const;

 private:
  explicit ContainerFile(std::filesystem::path path) : path_(std::move(path)) {}
  [[nodiscard]] std::optional<RecordHeader> record(const InputFile& file, std::int64_t number) const noexcept;
  [[nodiscard]] std::int64_t offset_of(std::int64_t number) const noexcept;

  std::filesystem::path path_;
  ContainerHeader header_;
  std::int64_t record_count_ = 0;
  std::size_t trailing_bytes_ = 0;
};

}  // namespace kinetrace::hal

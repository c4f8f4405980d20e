#include "formats/container_file.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <sys/uio.h>
#include <type_traits>
#include <utility>

#include "kinetrace/core/crc32.hpp"
#include "util/messages.hpp"

namespace kinetrace::hal {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are written as they lie in memory");

constexpr std::string_view kMagic = "KTRAW001";
constexpr std::string_view kRecordMagic = "KTFR";
constexpr std::size_t kFixedHeaderBytes = 8 + 4 + 4 + 8 + 4;
constexpr int kMaxSide_px = 16384;

template <typename T>
void put(char*& at, const T& value) noexcept {
  static_assert(std::is_trivially_copyable_v<T>);
  std::memcpy(at, &value, sizeof(T));
  at += sizeof(T);
}

template <typename T>
T get(const char*& at) noexcept {
  T value{};
  std::memcpy(&value, at, sizeof(T));
  at += sizeof(T);
  return value;
}

std::uint32_t crc_of(std::span<const char> bytes) noexcept {
  return Crc32().update(std::as_bytes(bytes)).value();
}

bool read_at(const InputFile& file, std::span<char> target, std::int64_t offset) noexcept {
  const std::span bytes(reinterpret_cast<std::uint8_t*>(target.data()), target.size());
  return file.read(static_cast<std::size_t>(offset), bytes) == bytes.size();
}

// Reads the rows of an image, many with one system call.
bool read_rows(const InputFile& file, MutableGrayView image, std::int64_t& offset) noexcept {
  constexpr int kRowsAtOnce = 64;
  const auto row_bytes = static_cast<std::size_t>(image.width);
  for (int first = 0; first < image.height; first += kRowsAtOnce) {
    std::array<iovec, kRowsAtOnce> rows{};
    const int count = std::min(kRowsAtOnce, image.height - first);
    for (int i = 0; i < count; ++i) {
      rows[static_cast<std::size_t>(i)] = {image.row(first + i), row_bytes};
    }
    const auto wanted = static_cast<ssize_t>(row_bytes) * count;
    if (preadv(file.descriptor(), rows.data(), count, offset) != wanted) {
      return false;
    }
    offset += wanted;
  }
  return true;
}

}  // namespace

std::size_t record_pixel_bytes(int width_px, int height_px) noexcept {
  return 2 * static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px);
}

std::size_t record_bytes(int width_px, int height_px) noexcept {
  return kRecordHeaderBytes + record_pixel_bytes(width_px, height_px);
}

Result<std::string> encode_header(const ContainerHeader& header) {
  if (header.calibration.size() > kContainerHeaderBytes - kFixedHeaderBytes - sizeof(std::uint32_t)) {
    return fail(ErrorCode::kInvalidArgument, "the calibration is too long for a container's header");
  }
  std::string bytes(kContainerHeaderBytes, '\0');
  char* at = std::copy(kMagic.begin(), kMagic.end(), bytes.data());
  put(at, static_cast<std::int32_t>(header.width_px));
  put(at, static_cast<std::int32_t>(header.height_px));
  put(at, header.rate_hz);
  put(at, static_cast<std::uint32_t>(header.calibration.size()));
  std::copy(header.calibration.begin(), header.calibration.end(), at);
  char* crc = bytes.data() + kContainerHeaderBytes - sizeof(std::uint32_t);
  put(crc, crc_of({bytes.data(), kContainerHeaderBytes - sizeof(std::uint32_t)}));
  return bytes;
}

void encode_record_header(const RecordHeader& record, std::span<std::byte, kRecordHeaderBytes> bytes) noexcept {
  auto* first = reinterpret_cast<char*>(bytes.data());
  char* at = std::copy(kRecordMagic.begin(), kRecordMagic.end(), first);
  char* crc = at;
  put(at, std::uint32_t{0});
  put(at, record.frame_index);
  put(at, record.timestamp_ns);
  put(at, record.pixel_crc);
  put(at, std::uint32_t{0});
  put(crc, crc_of({first + 8, kRecordHeaderBytes - 8}));
}

Result<ContainerFile> ContainerFile::open(const std::filesystem::path& path) {
  ContainerFile file(path);
  const Result<InputFile> opened = InputFile::open(path.c_str());
  if (!opened) {
    return Unexpected(opened.error());
  }
  std::string bytes(kContainerHeaderBytes, '\0');
  if (!read_at(*opened, bytes, 0) || !bytes.starts_with(kMagic)) {
    return fail(ErrorCode::kBadFormat, path.string() + ": not a container recording, or cut within its header");
  }
  const char* crc = bytes.data() + kContainerHeaderBytes - sizeof(std::uint32_t);
  const char* at = bytes.data() + kMagic.size();
  const bool is_whole =
      get<std::uint32_t>(crc) == crc_of({bytes.data(), kContainerHeaderBytes - sizeof(std::uint32_t)});
  ContainerHeader& header = file.header_;
  header.width_px = get<std::int32_t>(at);
  header.height_px = get<std::int32_t>(at);
  header.rate_hz = get<double>(at);
  const auto length = get<std::uint32_t>(at);
  const auto is_size = [](int pixels) { return pixels > 0 && pixels <= kMaxSide_px; };
  if (!is_whole || !is_size(header.width_px) || !is_size(header.height_px) || !std::isfinite(header.rate_hz) ||
      length > kContainerHeaderBytes - kFixedHeaderBytes - sizeof(std::uint32_t)) {
    return fail(ErrorCode::kBadFormat, path.string() + ": the header is damaged; its frames cannot be read");
  }
  header.calibration.assign(at, length);
  const std::size_t records_bytes = opened->size_bytes() - kContainerHeaderBytes;
  const std::size_t each_bytes = record_bytes(header.width_px, header.height_px);
  file.record_count_ = static_cast<std::int64_t>(records_bytes / each_bytes);
  file.trailing_bytes_ = records_bytes % each_bytes;
  return file;
}

std::int64_t ContainerFile::offset_of(std::int64_t number) const noexcept {
  return static_cast<std::int64_t>(kContainerHeaderBytes) +
         number * static_cast<std::int64_t>(record_bytes(header_.width_px, header_.height_px));
}

Status ContainerFile::for_each_record(const RecordVisitor& visit) const {
  const Result<InputFile> file = InputFile::open(path_.c_str());
  if (!file) {
    return Unexpected(file.error());
  }
  for (std::int64_t i = 0; i < record_count_; ++i) {
    visit(i, record(*file, i));
  }
  return {};
}

std::optional<RecordHeader> ContainerFile::record(const InputFile& file, std::int64_t number) const noexcept {
  std::array<char, kRecordHeaderBytes> bytes{};
  if (!read_at(file, bytes, offset_of(number)) || std::string_view(bytes.data(), kRecordMagic.size()) != kRecordMagic) {
    return std::nullopt;
  }
  const char* at = bytes.data() + kRecordMagic.size();
  if (get<std::uint32_t>(at) != crc_of({bytes.data() + 8, kRecordHeaderBytes - 8})) {
    return std::nullopt;
  }
  RecordHeader record;
  record.frame_index = get<std::int64_t>(at);
  record.timestamp_ns = get<std::int64_t>(at);
  record.pixel_crc = get<std::uint32_t>(at);
  return record;
}

InPlaceStatus ContainerFile::read(std::int64_t number, MutableGrayView left, MutableGrayView right) const {
  const InPlaceResult<InputFile> file = InputFile::open(path_.c_str());
  if (!file) {
    return Unexpected(file.error());
  }
  const std::optional<RecordHeader> expected = record(*file, number);
  std::int64_t offset = offset_of(number) + static_cast<std::int64_t>(kRecordHeaderBytes);
  Crc32 crc;
  bool is_whole = expected.has_value();
  for (const MutableGrayView& image : {left, right}) {
    is_whole = is_whole && read_rows(*file, image, offset);
    for (int y = 0; is_whole && y < image.height; ++y) {
      crc.update(std::as_bytes(std::span(image.row(y), static_cast<std::size_t>(image.width))));
    }
  }
  if (!is_whole || crc.value() != expected->pixel_crc) {
    return Unexpected(
        InPlaceError(ErrorCode::kBadFormat, path_.native(), {"record ", NumberText(number), " is damaged"}));
  }
  return {};
}

}  // namespace kinetrace::hal

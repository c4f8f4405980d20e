#include "exif_orientation.hpp"

#include <algorithm>
#include <array>
#include <cstdint>

namespace kinetrace::imaging {
namespace {

constexpr std::array<std::uint8_t, 6> kExifMagic{'E', 'x', 'i', 'f', 0, 0};
constexpr std::size_t kTiffHeaderBytes = 8;
constexpr std::size_t kEntryBytes = 12;
constexpr std::uint32_t kOrientationTag = 0x0112;

// The part of a file that holds a TIFF structure, with its byte order (TIFF 6.0, section 2).
class Tiff {
 public:
  Tiff(const InputFile& file, std::size_t begin, std::size_t length) : file_(file), begin_(begin), length_(length) {
    std::array<std::uint8_t, 2> order{};
    little_endian_ = file_.read(begin_, order) == order.size() && order[0] == 'I';
  }

  // 0 beyond the end.
  [[nodiscard]] std::uint32_t number(std::size_t offset, std::size_t count) const {
    std::array<std::uint8_t, 4> bytes{};
    if (offset + count > length_ || file_.read(begin_ + offset, std::span(bytes).first(count)) != count) {
      return 0;
    }
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < count; ++i) {
      value = value << 8U | bytes[little_endian_ ? count - 1 - i : i];
    }
    return value;
  }

 private:
  const InputFile& file_;
  std::size_t begin_;
  std::size_t length_;
  bool little_endian_ = false;
};

}  // namespace

int exif_orientation(const InputFile& file, std::size_t offset, std::size_t length) {
  std::array<std::uint8_t, kExifMagic.size()> magic{};
  if (length < kExifMagic.size() + kTiffHeaderBytes || file.read(offset, magic) != magic.size() ||
      magic != kExifMagic) {
    return kExifUpright;
  }
  const Tiff tiff(file, offset + kExifMagic.size(), length - kExifMagic.size());
  const std::size_t directory = tiff.number(4, 4);
  const std::size_t entries = tiff.number(directory, 2);
  for (std::size_t i = 0; i < entries; ++i) {
    const std::size_t entry = directory + 2 + i * kEntryBytes;
    if (tiff.number(entry, 2) == kOrientationTag) {
      const int orientation = static_cast<int>(tiff.number(entry + 8, 2));
      return orientation >= 1 && orientation <= 8 ? orientation : kExifUpright;
    }
  }
  return kExifUpright;
}

}  // namespace kinetrace::imaging

#include "kinetrace/imaging/mask_rle.hpp"

#include <cstddef>
#include <string>

namespace kinetrace::imaging {
namespace {

constexpr int kAlphabetBegin = 48;
constexpr int kAlphabetSize = 64;
constexpr int kGroupBits = 5;
constexpr int kGroupMask = 0x1f;
constexpr int kSignBit = 0x10;
constexpr int kMoreBit = 0x20;
constexpr int kMaxNumberBits = 60;

Unexpected<Error> malformed(std::size_t position, const std::string& reason) {
  return fail(ErrorCode::kBadFormat, "run-length string, character " + std::to_string(position + 1) + ": " + reason +
                                         "; write the mask again");
}

/// Reads the numbers of a run-length string one after the other.
class NumberReader {
 public:
  explicit NumberReader(std::string_view text) noexcept : text_(text) {}

  [[nodiscard]] bool at_end() const noexcept { return position_ == text_.size(); }
  [[nodiscard]] std::size_t position() const noexcept { return position_; }

  Result<std::int64_t> next() {
    std::int64_t value = 0;
    int shift = 0;
    int group = kMoreBit;
    while ((group & kMoreBit) != 0) {
      if (at_end()) {
        return malformed(position_, "ends within a number");
      }
      group = static_cast<unsigned char>(text_[position_]) - kAlphabetBegin;
      if (group < 0 || group >= kAlphabetSize) {
        return malformed(position_, "no character of the run-length alphabet ('0' to 'o')");
      }
      if (shift == kMaxNumberBits) {
        return malformed(position_, "number beyond 60 bits");
      }
      value |= static_cast<std::int64_t>(group & kGroupMask) << shift;
      shift += kGroupBits;
      ++position_;
    }
    return (group & kSignBit) != 0 ? value - (std::int64_t{1} << shift) : value;
  }

 private:
  std::string_view text_;
  std::size_t position_ = 0;
};

}  // namespace

bool has_label(LabelView labels, const PixelBox& box, std::uint8_t label) noexcept {
  const int x0 = std::max(box.x0, 0);
  const int x1 = std::min(box.x1, labels.width);
  for (int y = std::max(box.y0, 0); y < std::min(box.y1, labels.height); ++y) {
    const std::uint8_t* row = labels.row(y);
    if (x1 > x0 && std::find(row + x0, row + x1, label) != row + x1) {
      return true;
    }
  }
  return false;
}

std::string_view RunLengthEncoder::next(std::int64_t length) noexcept {
  std::int64_t value = index_ > 2 ? length - before_last_ : length;
  before_last_ = last_;
  last_ = length;
  ++index_;
  std::size_t size = 0;
  for (bool more = true; more;) {
    const std::int64_t group = value & kGroupMask;
    value >>= kGroupBits;  // Arithmetic: a negative number ends in copies of its sign.
    more = (group & kSignBit) != 0 ? value != -1 : value != 0;
    text_[size++] = static_cast<char>(kAlphabetBegin + (group | (more ? kMoreBit : 0)));
  }
  return {text_.data(), size};
}

Result<std::vector<MaskRun>> decode_mask_rle(std::string_view text, int width, int height) {
  if (width < 1 || height < 1) {
    return fail(ErrorCode::kInvalidArgument, "run-length string of an image of " + std::to_string(width) + " x " +
                                                 std::to_string(height) + " pixels: sizes begin at 1");
  }
  const std::int64_t pixels = static_cast<std::int64_t>(width) * height;
  std::vector<MaskRun> runs;
  NumberReader numbers(text);
  std::int64_t position = 0;
  std::int64_t last = 0;
  std::int64_t before_last = 0;
  for (int index = 0; !numbers.at_end(); ++index) {
    const std::size_t place = numbers.position();
    const Result<std::int64_t> number = numbers.next();
    if (!number) {
      return Unexpected(number.error());
    }
    const std::int64_t length = index > 2 ? before_last + *number : *number;
    if (length < 0 || length > pixels - position) {
      return malformed(place, length < 0 ? "negative length" : "more pixels than the image has");
    }
    if (index % 2 == 1 && length > 0) {
      runs.push_back({position, position + length});
    }
    position += length;
    before_last = last;
    last = length;
  }
  if (position != pixels) {
    return malformed(text.size(), "fewer pixels than the image has");
  }
  return runs;
}

}  // namespace kinetrace::imaging

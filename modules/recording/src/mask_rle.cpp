#include "mask_rle.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <string_view>

namespace kinetrace::recording {
namespace {

PixelBox clipped(const PixelBox& box, LabelView labels) noexcept {
  return {std::max(box.x0, 0), std::max(box.y0, 0), std::min(box.x1, labels.width), std::min(box.y1, labels.height)};
}

/// Turns run lengths into characters as they become known.
class RunEncoder {
 public:
  explicit RunEncoder(BufferedWriter& out) noexcept : out_(out) {}

  void count(std::int64_t length) noexcept {
    const std::int64_t delta = index_ > 2 ? length - before_last_ : length;
    before_last_ = last_;
    last_ = length;
    ++index_;
    characters(delta);
  }

 private:
  void characters(std::int64_t value) noexcept {
    std::array<char, 16> text;
    std::size_t size = 0;
    for (bool more = true; more;) {
      const std::int64_t group = value & 0x1f;
      value >>= 5;  // Arithmetic: a negative number ends in copies of its sign.
      more = (group & 0x10) != 0 ? value != -1 : value != 0;
      text[size++] = static_cast<char>(48 + (group | (more ? 0x20 : 0)));
    }
    out_.text(std::string_view(text.data(), size));
  }

  BufferedWriter& out_;
  int index_ = 0;
  std::int64_t last_ = 0;
  std::int64_t before_last_ = 0;
};

}  // namespace

bool has_label(LabelView labels, const PixelBox& box, std::uint8_t label) noexcept {
  const PixelBox inside = clipped(box, labels);
  for (int y = inside.y0; y < inside.y1; ++y) {
    const std::uint8_t* row = labels.row(y);
    if (inside.x1 > inside.x0 && std::find(row + inside.x0, row + inside.x1, label) != row + inside.x1) {
      return true;
    }
  }
  return false;
}

void write_mask_rle(LabelView labels, const PixelBox& box, std::uint8_t label, BufferedWriter& out) noexcept {
  const PixelBox inside = clipped(box, labels);
  RunEncoder encoder(out);
  std::int64_t run_begin = 0;  // Column-major positions of the foreground run that is being collected.
  std::int64_t run_end = 0;
  std::int64_t written_end = 0;
  const auto write_run = [&] {
    if (run_end > run_begin) {
      encoder.count(run_begin - written_end);
      encoder.count(run_end - run_begin);
      written_end = run_end;
    }
  };
  for (int x = inside.x0; x < inside.x1; ++x) {
    const std::int64_t column = static_cast<std::int64_t>(x) * labels.height;
    for (int y = inside.y0; y < inside.y1; ++y) {
      if (labels.row(y)[x] != label) {
        continue;
      }
      const std::int64_t position = column + y;
      if (position != run_end || run_end == run_begin) {
        write_run();
        run_begin = position;
      }
      run_end = position + 1;
    }
  }
  write_run();
  const std::int64_t pixels = static_cast<std::int64_t>(labels.width) * labels.height;
  if (pixels > written_end) {
    encoder.count(pixels - written_end);
  }
}

}  // namespace kinetrace::recording

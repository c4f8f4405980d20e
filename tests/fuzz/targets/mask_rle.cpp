// COCO run lengths of a mask: "WIDTH HEIGHT TEXT", as a row of mots.txt has them.
#include "kinetrace/imaging/mask_rle.hpp"

#include <algorithm>
#include <string>

#include "fuzz_target.hpp"
#include "kinetrace/core/text_rows.hpp"

void kinetrace::fuzz::try_input(std::string_view input) {
  const auto word = [&input] {
    const std::size_t end = std::min(input.find(' '), input.size());
    const std::string_view first = input.substr(0, end);
    input.remove_prefix(std::min(end + 1, input.size()));
    return first;
  };
  const auto width = parse_integer(word());
  const auto height = parse_integer(word());
  if (!width || !height || *width != static_cast<int>(*width) || *height != static_cast<int>(*height)) {
    return;
  }
  const auto runs = imaging::decode_mask_rle(input, static_cast<int>(*width), static_cast<int>(*height));
  std::int64_t end = 0;
  for (std::size_t i = 0; runs && i < runs->size(); ++i) {
    const imaging::MaskRun& run = (*runs)[i];
    require(run.begin >= end && run.end > run.begin && run.end <= *width * *height);
    end = run.end;
  }
}

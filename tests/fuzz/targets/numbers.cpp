// Numbers, times and dates in text, as recordings and run folders have them.
#include "fuzz_target.hpp"
#include "kinetrace/core/text_rows.hpp"
#include "util/text_file.hpp"

void kinetrace::fuzz::try_input(std::string_view input) {
  for (const std::string_view line : hal::content_lines(input)) {
    static_cast<void>(hal::parse_double(line));
    static_cast<void>(hal::parse_integer(line));
    static_cast<void>(hal::parse_numbers(line));
    static_cast<void>(hal::parse_time_ns(line));
    static_cast<void>(parse_number(line));
    static_cast<void>(parse_integer(line));
    static_cast<void>(parse_time_ns(line));
  }
}

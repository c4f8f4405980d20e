#include "fuzz_target.hpp"

#include <algorithm>
#include <cstdint>
#include <cstdlib>

namespace kinetrace::fuzz {

std::vector<std::string_view> parts_of(std::string_view input, std::size_t count) {
  std::vector<std::string_view> parts(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t end = i + 1 < count ? std::min(input.find(kPartMark), input.size()) : input.size();
    parts[i] = input.substr(0, end);
    input.remove_prefix(std::min(end + kPartMark.size(), input.size()));
  }
  return parts;
}

void require(bool holds) {
  if (!holds) {
    std::abort();
  }
}

}  // namespace kinetrace::fuzz

// Called by libFuzzer.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size);
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  kinetrace::fuzz::try_input({reinterpret_cast<const char*>(bytes), size});
  return 0;
}

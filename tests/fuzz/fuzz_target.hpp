// What all fuzz targets share: the call that each of them answers, and inputs that stand for several files or values.
#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

namespace kinetrace::fuzz {

/// One input; each target defines this. A crash, a sanitizer's report, an exception that comes out, a hang and memory
/// beyond the limit are findings; errors that the parser returns are not.
void try_input(std::string_view input);

/// Between the parts of an input that stands for several files.
inline constexpr std::string_view kPartMark = "\n=====\n";

/// The first `count` parts; what is missing is empty, and the last one has all the rest.
[[nodiscard]] std::vector<std::string_view> parts_of(std::string_view input, std::size_t count);

/// Ends the program where `holds` is false: what a parser accepted must have this property.
void require(bool holds);

}  // namespace kinetrace::fuzz

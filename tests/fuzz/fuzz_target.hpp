// Code shared by all fuzz targets: their entry point, and inputs that stand for several files or values.
#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

namespace kinetrace::fuzz {

/// Processes one input; each target defines this. Findings are a crash, a sanitizer report, an escaping exception, a
/// hang and memory beyond the limit, but not errors that the parser returns.
void try_input(std::string_view input);

/// Separates the parts of an input that stands for several files.
inline constexpr std::string_view kPartMark = "\n=====\n";

/// The first `count` parts; missing parts are empty, the last one has all the rest.
[[nodiscard]] std::vector<std::string_view> parts_of(std::string_view input, std::size_t count);

/// Aborts if `holds` is false: accepted input must have this property.
void require(bool holds);

}  // namespace kinetrace::fuzz

// Reads the priors of object sizes from a file.
#pragma once

#include <filesystem>

#include "kinetrace/core/result.hpp"
#include "kinetrace/trajectory/size_table.hpp"

namespace kinetrace::app {

/// Reads a YAML file like config/sizes.yaml: a list `kinds` of maps with class (car, pedestrian, unknown, other, or the
/// segmentation's number), share, length, height, width (mean and standard deviation, m), and shape (box or saloon).
/// Errors, with file and line: kNotFound, kIo, kInvalidConfig (another kind of file, a value out of range, more than
/// SizeTable::kMaxKinds, no kind for other classes).
[[nodiscard]] Result<trajectory::SizeTable> read_size_file(const std::filesystem::path& path);

}  // namespace kinetrace::app

// How a recording's image files are read.
#pragma once

#include "kinetrace/hal/dataset.hpp"
#include "kinetrace/imaging/image_reader.hpp"

namespace kinetrace::hal {

[[nodiscard]] imaging::ImageReaderConfig image_reader_config(const Dataset& dataset);

/// Dataset::sample_bits, from images all over the recording: cameras of 10, 12 and 14 bits are often written into 16
/// without being scaled, which would leave next to nothing of them in 8. Adds a note where that is so.
void find_sample_bits(Dataset& dataset);

}  // namespace kinetrace::hal

// Reading of a recording's image files.
#pragma once

#include "kinetrace/hal/dataset.hpp"
#include "kinetrace/imaging/image_reader.hpp"

namespace kinetrace::hal {

[[nodiscard]] imaging::ImageReaderConfig image_reader_config(const Dataset& dataset);

/// Sets Dataset::sample_bits from images spread over the recording: values of 10, 12 and 14 bits are often stored
/// unscaled in 16 bits; their upper 8 bits would be almost empty. Adds a note in that case, and where the views differ.
void find_sample_bits(Dataset& dataset);

}  // namespace kinetrace::hal

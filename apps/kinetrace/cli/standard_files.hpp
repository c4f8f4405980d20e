// Standard input, output and error: open at start, flushed at the end.
#pragma once

#include <optional>
#include <string>

namespace kinetrace::app {

/// Call first. Replaces closed standard files by /dev/null, opened for reading, so that no other file gets their
/// descriptor and receives printed text. From now on a write to a closed pipe, or beyond the file size limit, fails
/// with an ordinary error instead of ending the process.
void prepare_standard_files() noexcept;

/// Call last. The reason why standard output is incomplete; none if it is complete.
[[nodiscard]] std::optional<std::string> output_failure();

}  // namespace kinetrace::app

// Standard input, output and error: there when the program begins, and written when it ends.
#pragma once

#include <optional>
#include <string>

namespace kinetrace::app {

/// First of all. Those that are closed become unusable ones, so that no file of ours gets their number and is printed
/// into. From now on, a write to a pipe that nobody reads, or beyond the size that a file may have, fails with an error
/// as any other, which is reported where it is written, instead of ending the process.
void prepare_standard_files() noexcept;

/// Last of all. Why standard output does not hold all that was printed; none if it does.
[[nodiscard]] std::optional<std::string> output_failure();

}  // namespace kinetrace::app

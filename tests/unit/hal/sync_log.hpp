// Records the data that the program makes durable against a loss of power.
#pragma once

#include <string>
#include <vector>

namespace kinetrace::hal::test {

/// Calls of fsync ("file"), fdatasync ("data") and syncfs ("disk") with the path each was called for, since the last
/// look. The calls are passed on.
[[nodiscard]] std::vector<std::pair<std::string, std::string>> take_syncs();

}  // namespace kinetrace::hal::test

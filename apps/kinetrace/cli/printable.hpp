// Escapes untrusted text for a terminal.
#pragma once

#include <string>
#include <string_view>

namespace kinetrace::app {

/// The text with bytes that a terminal would interpret replaced by \xNN, one for each byte: ASCII control characters
/// (line ends, too), those of Unicode (U+0080 to U+009F), and invalid UTF-8.
[[nodiscard]] std::string printable(std::string_view text);

}  // namespace kinetrace::app

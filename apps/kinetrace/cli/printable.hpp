// Text from files and networks on its way to a terminal.
#pragma once

#include <string>
#include <string_view>

namespace kinetrace::app {

/// The text with everything that a terminal would obey instead of showing as \xNN, one for each byte: control
/// characters of ASCII (line ends, too), those of Unicode (U+0080 to U+009F), and whatever is not UTF-8.
[[nodiscard]] std::string printable(std::string_view text);

}  // namespace kinetrace::app

// Error messages for a wrong command line.
#pragma once

#include <string>

// NOLINTNEXTLINE(readability-identifier-naming): theirs.
namespace CLI {
class App;
class ParseError;
}  // namespace CLI

namespace kinetrace::app {

/// One line: the unknown word with the nearest known one, or else the parser's own message. Call after `program` has
/// failed to parse.
[[nodiscard]] std::string command_error(const CLI::App& program, const CLI::ParseError& error);

}  // namespace kinetrace::app

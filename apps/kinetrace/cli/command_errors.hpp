// What is wrong with a command line, in words that name it.
#pragma once

#include <string>

// NOLINTNEXTLINE(readability-identifier-naming): theirs.
namespace CLI {
class App;
class ParseError;
}  // namespace CLI

namespace kinetrace::app {

/// One line: the word that is not known, with the nearest one that is; or else what the parser says is missing or
/// wrong. After `program` has failed to parse.
[[nodiscard]] std::string command_error(const CLI::App& program, const CLI::ParseError& error);

}  // namespace kinetrace::app

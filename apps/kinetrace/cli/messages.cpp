#include "cli/messages.hpp"

#include <cstdio>
#include <string>

#include "cli/printable.hpp"
#include "cli/progress.hpp"

namespace kinetrace::app {
namespace {

constexpr const char* kRed = "\033[1;31m";
constexpr const char* kYellow = "\033[1;33m";

void print(const char* colour, const char* kind, std::string_view message) {
  const bool has_color = stderr_has_color();
  // The text may contain file names or data from the network.
  const std::string shown = printable(message);
  std::fflush(stdout);  // Both may go into one file.
  std::fprintf(stderr, "kinetrace: %s%s%s %s\n", has_color ? colour : "", kind, has_color ? "\033[0m" : "",
               shown.c_str());
}

}  // namespace

void print_error(std::string_view message) {
  print(kRed, "error:", message);
}

void print_warning(std::string_view message) {
  print(kYellow, "warning:", message);
}

int report(const Failure& failure) {
  print_error(failure.message);
  return static_cast<int>(failure.code);
}

}  // namespace kinetrace::app
